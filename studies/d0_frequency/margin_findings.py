"""The finding of d0 on margins: those of one joint beside that of both at once, at poses and over draws."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.d0_frequency.draws import COUNT, DRAWN_POSES, draws_by_pose
from studies.d0_frequency.loops import ARM_POSES, CONTINUOUS, SHORT, AtPose
from studies.d0_frequency.rest_answers import over_poses, rests
from studies.d0_frequency.tables import number
from studies.paper.card import LAWS
from studies.paper.linearization import LEVEL

LATE = f"{1e3 * SHORT:g} ms"


def shares(results: wb.Results) -> dict[str, dict[str, float]]:
    """By law and pose the disk margin of both joints at once over the least of a joint, where the loop is stable."""
    held = rests(results)
    return {
        law: {pose: one.alpha / one.single for pose, one in over_poses(held, law).items() if one.stable} for law in LAWS
    }


def least(margin_shares: dict[str, dict[str, float]]) -> tuple[str, str]:
    """The law and the pose with the least share."""
    places = [(law, pose) for law, poses in margin_shares.items() for pose in poses]
    return min(places, key=lambda place: margin_shares[place[0]][place[1]])


def one_channel(results: wb.Results) -> wb.Finding:
    """The margins of one joint beside that of both at once."""
    held = shares(results)
    law, pose = least(held)
    answer = rests(results)[AtPose(law, pose)][CONTINUOUS]
    variations = []
    for place in ARM_POSES:
        some = {name: {place: poses[place]} for name, poses in held.items()}
        worst, _ = least(some)
        variations.append(wb.Variation(f"the pose '{place}'", worst, f"{number(some[worst][place])}"))
    late = {one: rests(results)[AtPose(one, LEVEL)][LATE] for one in LAWS}
    parts = {one: found.alpha / found.single for one, found in late.items() if found.stable}
    worst = min(parts, key=lambda one: parts[one])
    variations.append(
        wb.Variation(f"a period of {LATE}, the torque one period late, {LEVEL}", worst, number(parts[worst]))
    )
    others = {name: poses for name, poses in held.items() if name != law}
    worst, at = least(others)
    variations.append(wb.Variation(f"without {law}", worst, f"{number(others[worst][at])}, {at}"))
    return wb.Finding(
        name="one_joint_or_both",
        statement=f"{law} ({pose}) has a disk margin of {number(answer.single)} if the torque of one joint is changed, "
        f"and of {number(answer.alpha)} if both are changed at once: {number(100 * held[law][pose], 2)} % of the "
        "margin of one joint, the least share of all laws and poses.",
        evidence=drawn_words(results),
        statistic="The disk margin of both torques at once, divided by the smaller margin of a single joint with the "
        "other loop closed. The answer is the law with the least share.",
        sample=f"{len(LAWS)} laws at {len(ARM_POSES)} poses in continuous time; {COUNT} draws of three laws at "
        f"{len(DRAWN_POSES)} poses.",
        information="AOSMC-RGS: only positions. Other laws: exact positions and velocities. All laws but PID: the "
        "exact model, in the draws a wrong one.",
        assumptions="The numbers of the laws as in report a1, adaptive gains at K(0); the ranges of the draws, as in "
        "a7.",
        fitted_numbers="Q and R of AOSMC-RGS, to its printed RMSE (report a1).",
        answer=law,
        variations=tuple(variations),
        limitations="Cuts at the readings, and draws of learned gains.",
    )


def drawn_words(results: wb.Results) -> str:
    """A sentence on the draws: those without rest, and the loss of margin of the worst."""
    every = draws_by_pose(results)
    lost = {one: COUNT - own.rest_count for one, own in every.items()}
    without = max(lost, key=lambda one: lost[one])
    falls = {one: own.own - float(np.nanmin(own.alpha)) for one, own in every.items()}
    worst = max(falls, key=lambda one: falls[one])
    unstable = sum(int((own.alpha == 0).sum()) for own in every.values())
    rested = sum(own.rest_count for own in every.values())
    return (
        f"With the numbers of arm, model and law drawn at random, {unstable} of {rested} loops at rest are unstable. "
        f"The margin of both joints falls farthest for {worst.law} ({worst.pose}), from {number(every[worst].own)} to "
        f"{number(float(np.nanmin(every[worst].alpha)))} in the worst draw. {without.law} ({without.pose}) has no "
        f"equilibrium within the layer in {lost[without]} of {COUNT} draws."
    )
