"""Findings of a8 from given costs: each law's cost as a share of the same draws."""

import numpy as np

from studies.a8_fair_comparison.ablations import RICCATI, STEADY
from studies.a8_fair_comparison.evidence import Evidence, Parts
from studies.a8_fair_comparison.other_numbers import AGAIN, PLAIN, run_name
from studies.paper.costs import judge_laws, judge_means
from studies.paper.entrants import ALL_INFORMATION, PROPOSED_LAW
from workbench.study.evidence import Standings, leave_one_out, pair_samples
from workbench.study.evidence.pooling import WAYS

RNG = np.random.default_rng(5)
LONG = np.abs(RNG.normal(size=160)) + 1


def costs(**shares):
    """Costs by scenario: each law's cost as a share of the same draws; None for a law that fails."""
    return {
        scenario: pair_samples(
            {law: np.full(160, np.nan) if s is None else s * LONG for law, s in laws.items()}, metric="cost"
        )
        for scenario, laws in shares.items()
    }


def standings(members):
    return Standings({scenario: judge_laws(one) for scenario, one in members.items()})


PART = {PROPOSED_LAW: 1.0, PLAIN: 1.04, RICCATI: 1.0, STEADY: 1.0}
PARTS_OF_IT = costs(a=PART, b=PART)


def searched(retuned, **changed):
    """The laws of `retuned` with the numbers of each search, which cost the same but for the laws that are changed."""
    return {
        scenario: pair_samples(
            {
                run_name(law, kind): changed.get(law + kind, 1.0) * one.values[:, one.place(law)]
                for law in (PROPOSED_LAW, RICCATI, PLAIN)
                for kind in ("", *AGAIN)
            },
            metric="cost",
        )
        for scenario, one in retuned.items()
    }


def evidence(members, again=None, weighted=None, frozen=PARTS_OF_IT, retuned=PARTS_OF_IT, **changed):
    """All judgements that findings are made of, the same whatever a law measures."""
    pooled = {way: leave_one_out(members, judge_means, way) for way in WAYS}
    parts = Parts(
        leave_one_out(frozen, judge_means),
        {way: leave_one_out(retuned, judge_means, way) for way in WAYS},
        leave_one_out(searched(retuned, **changed), judge_means),
        (),
    )
    held = [
        {given.key: one for given in ALL_INFORMATION}
        for one in (standings(members), pooled, again or {}, weighted or {})
    ]
    return Evidence({}, *held, {}, parts)


WINS, LOSES = {PROPOSED_LAW: 1.0, "SMC": 2.0, "PID": 3.0}, {PROPOSED_LAW: 2.0, "SMC": 1.0, "PID": 3.0}
