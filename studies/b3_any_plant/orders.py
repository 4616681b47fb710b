"""The order of both laws by every statistic of b3, and how it changes without some of the settings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import COMPUTER, DIGITAL, LAWS, LQG, PID, all_margins, errors
from studies.b3_any_plant.settings import HAND, PUBLISHED, REGULATOR, SETTINGS, Setting

Orders = Mapping[str, str]  # by setting: LQG 'below' or 'above' PID, or neither
MARGINS = ("disk", "delay")  # of which the larger is better
BY_ORIGIN = {origin: sum(s.pid.origin == origin for s in SETTINGS) for origin in (HAND, PUBLISHED, REGULATOR)}
ORIGIN = (
    f"gains chosen by hand with the model known ({BY_ORIGIN[HAND]} settings), published ({BY_ORIGIN[PUBLISHED]}), or "
    f"those of LQG's regulator with filtered derivatives for velocities ({BY_ORIGIN[REGULATOR]})"
)


def _pair(results: wb.Results, setting: Setting, law: str, name: str) -> tuple[float, float]:
    """A statistic of a law in a setting, with its error."""
    return results[setting.name, law].score(name if name == "TV" else f"{name} of {setting.main}").pair


def _order(results: wb.Results, setting: Setting, where: str, name: str) -> str:
    """The side on which the first law lies of the second, by a statistic in a setting."""
    first, second = (_pair(results, setting, f"{law}{where}", name) for law in LAWS)
    return wb.evidence.order(first, second)


def orders(results: wb.Results) -> dict[str, Orders]:
    """By statistic, the RMSE in continuous time first: the order of both laws in each setting, less being better."""
    made: dict[str, Orders] = {}
    for name in ("RMSE", "settling time", "TV"):
        for where in ("", f" {COMPUTER}"):
            time = DIGITAL if where else "in continuous time"
            words = f"{'total variation of the command' if name == 'TV' else name} {time}"
            made[words] = {s.name: _order(results, s, where, name) for s in SETTINGS}
    made["mean RMSE over the parameters"] = {
        s.name: order_of(*(float(np.nanmean(one)) for one in both(results, s))) for s in SETTINGS
    }
    by = all_margins(results)
    for words in MARGINS:
        made[f"{words} margin"] = {
            s.name: order_of(*(-getattr(by[s.name, law], words) for law in LAWS)) for s in SETTINGS
        }
    return made


def both(results: wb.Results, setting: object) -> Iterable[np.ndarray]:
    """The errors of the runs over the parameters, under LQG and under PID."""
    return (errors(results, setting, law) for law in LAWS)  # type: ignore[arg-type]


def order_of(one: float, other: float) -> str:
    """The order of two numbers without an error."""
    return "below" if one < other else "above" if one > other else "equal"


def standing(one: Orders) -> tuple[int, int]:
    """The number of settings in which LQG is below PID, and above it."""
    words = list(one.values())
    return words.count("below"), words.count("above")


def leader(one: Orders, *, larger: bool = False) -> str:
    """The law that is below the other in more settings, or above it; 'neither' where both are in as many."""
    less, more = standing(one)
    return "neither" if less == more else LQG if (more > less) is larger else PID


def variations_of(every: Mapping[str, Orders], *, larger: bool = False) -> tuple[wb.Variation, ...]:
    """Each statistic with all settings, without each setting by turns, and without those where both gains are one."""
    made = []
    for i, (words, one) in enumerate(every.items()):
        whole = leader(one, larger=larger)
        if i:
            made.append(wb.Variation(f"{words}", whole, count_words(words, one, larger=larger)))
        without = {name: {k: v for k, v in one.items() if k != name} for name in one}
        other = {name: leader(rest, larger=larger) for name, rest in without.items()}
        changed = {name: word for name, word in other.items() if word != whole}
        answer = next(iter(changed.values()), whole)
        detail = f"if one of these is left out: {', '.join(changed)}" if changed else ""
        made.append(wb.Variation(f"{words}, leaving out one setting", answer, detail))
        some = {s.name: one[s.name] for s in SETTINGS if s.pid.origin != REGULATOR}
        made.append(
            wb.Variation(
                f"{words}, in settings where PID has other gains than LQG",
                leader(some, larger=larger),
                count_words(words, some, larger=larger),
            )
        )
    return tuple(made)


def count_words(name: str, one: Orders, *, larger: bool = False) -> str:
    """Both counts in words: of the law whose statistic is larger, where that is asked for, or lower.

    The order of a margin has the opposite sign, so that "below" is the better law; its words count the larger margin.
    """
    less, more = standing(one)
    is_margin = name in {f"{margin} margin" for margin in MARGINS}
    ours, theirs = (more, less) if larger else (less, more)
    word = "larger" if larger or is_margin else "lower"
    return f"LQG {word} in {ours} setting{'s' * (ours != 1)}, PID in {theirs}"
