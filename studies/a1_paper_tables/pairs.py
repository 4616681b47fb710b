"""The printed order of the six laws: a count of its pairs, which the unstated numbers of the rivals decide."""

from collections.abc import Iterator

import workbench as wb
from studies.a1_paper_tables import six_laws
from studies.paper.card import CARD, LAWS, MARGIN, PUBLISHED_COLUMNS, SCENARIOS
from studies.paper.unstated_choices import CHOICES, assumptions, omitted_choices


def order_of_laws(results: wb.Results) -> wb.Finding:
    """The printed order of the six laws."""
    holds, reversed_, close = six_laws.count_pairs(results)
    total = holds + reversed_ + close
    first, last = (six_laws.reaching_time(six_laws.six(results, "FS", K)["SMC"]) for K in (None, max(six_laws.FIRM)))
    varied = ("K of joint 1", "K of joint 2", "error in (43)")
    return wb.Finding(
        "order_of_laws",
        f"With the numbers assumed here for the rivals, {holds} of {total} printed pairs of laws keep their order; "
        f"{reversed_} are reversed and {close} are too close to call.",
        "The paper states no parameter of a rival, so its order can neither be confirmed nor refuted by such runs. "
        f"With K = {CARD['SMC: K'][0]:g} N m, SMC reaches its layer in the first scenario at {first:.2f} s; with "
        f"{max(six_laws.FIRM):g} N m at {last:.2f} s.",
        statistic="The share of pairs that keep their order by the sampled RMSE, (43), at a joint: fewer than half, "
        f"or half or more. A pair is too close to call within {100 * MARGIN:g} % or within both errors.",
        sample="One run without noise for each law and scenario; fifteen pairs for each scenario and joint.",
        information="Rivals: exact positions and velocities. AOSMC-RGS: positions and the true disturbance. All but "
        "PID: the exact model. No torque limits.",
        assumptions=(f"The {len(CHOICES)} choices of ", wb.document.CrossReference("unstated"), "."),
        fitted_numbers=f"AOSMC-RGS alone, to its printed rows: {assumptions(CHOICES, of_fit=True)}. No rival.",
        answer=_share(holds, total),
        variations=tuple(_other_orders(results)),
        limitations=(
            f"The {len(omitted_choices(varied))} choices of ",
            wb.document.CrossReference("unstated"),
            " other than K of SMC and the error in (43). Report a6 varies many of them.",
        ),
    )


def _share(holds: int, total: int) -> str:
    return "fewer than half" if 2 * holds < total else "half or more"


def _other_orders(results: wb.Results) -> Iterator[wb.Variation]:
    """The count with other gains of SMC, margins, metrics, columns and laws."""

    def one(words: str, counts: tuple[int, int, int]) -> wb.Variation:
        return wb.Variation(words, _share(counts[0], sum(counts)), f"{counts[0]} of {sum(counts)}")

    for K in six_laws.FIRM:
        yield one(f"K of SMC = {K:g} N m", six_laws.count_pairs(results, K))
    for margin in (0.0, 0.05):
        yield one(f"pairs apart by more than {100 * margin:g} %", six_laws.count_pairs(results, margin=margin))
    for metric in ("RMSE", "RMSE of e_hat"):
        yield one(f"{metric} in place of sampled RMSE", six_laws.count_pairs(results, metric=metric))
    for (scenario, joint), column in PUBLISHED_COLUMNS.items():
        yield one(f"{SCENARIOS[scenario]}, joint {joint} alone", six_laws.count_pairs(results, columns=(column,)))
    for law in LAWS:
        yield one(f"without {law}", six_laws.count_pairs(results, without=law))
