"""Which numbers decide how well each law tracks, how much it chatters and what it costs?

Runs in about two minutes on two cores.
"""

from collections.abc import Sequence
from functools import cache

from studies.a7_sensitivity.answers import (
    answers,
    chattering,
    deciding_gain,
    groups,
    idle_gains,
    late_error_of,
    late_errors,
)
from studies.a7_sensitivity.gradients import gradients
from studies.a7_sensitivity.laws import proposed, rivals, spread
from studies.a7_sensitivity.local import Local, local
from studies.a7_sensitivity.results import found
from studies.a7_sensitivity.sweeps import LAWS, PROPOSED, SEED, loop, sweeps
from studies.a7_sensitivity.trust import stress, trust, varied
from workbench.study.document.document import Section
from workbench.study.study import Results, Study


@cache
def locals_of_all() -> dict[str, Local]:
    """The derivatives of every law, computed once."""
    return {law: local(law) for law in LAWS}


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    all_laws = {law: found(results, law) for law in LAWS}
    return (
        answers(all_laws),
        varied(),
        proposed(all_laws),
        *rivals(all_laws),
        groups(all_laws),
        spread(all_laws),
        gradients(all_laws, locals_of_all()),
        trust(all_laws, [stress(one) for one in all_laws.values()]),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    ours = found(results, PROPOSED)
    verdicts = (
        deciding_gain(ours),
        idle_gains(ours),
        late_error_of(ours),
        chattering(ours),
        late_errors({law: found(results, law) for law in LAWS}),
    )
    return tuple(f"{verdict.kind}: {verdict.statement}" for verdict in verdicts)


study = Study(
    name="a7_sensitivity",
    title="AOSMC-RGS and its rivals: which numbers decide",
    question=(
        "Of the design gains, the arm and the law's model of it: which decide the errors, the chattering and the "
        "effort of AOSMC-RGS and of each of its rivals, alone and together? And does the exact derivative at the "
        "numbers of the card foretell that?"
    ),
    method=(
        "First scenario. All factors are screened by Morris's effects; Sobol indices of first, second and total "
        "order follow for those that the screening leaves, with a quadratic polynomial as control variate; a "
        "sentence rests only on intervals narrower than 0.1. A tornado moves each factor of AOSMC-RGS by itself; "
        "random runs give bands over time. Derivatives come from the equations themselves. No index is computed "
        "from a sample with a failed run."
    ),
    sections=sections,
    headlines=headlines,
    fingerprints={law: loop(law).ode().fingerprint[:16] for law in LAWS},
    seed=SEED,
    sweeps=tuple(sweep for law in LAWS for sweep in sweeps(law)),
)
