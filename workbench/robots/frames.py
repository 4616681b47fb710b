"""Named places on the bodies of an arm: a tool, a camera, a flange."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from workbench.validation.refusals import Array, described, known, matrix, vector
from workbench.validation.refusals import name as check_name
from workbench.validation.signatures import door

ORTHONORMAL = 1e-12  # what rounding leaves of a rotation


@dataclass(frozen=True, eq=False)
@door
class Frame:
    """A frame fixed to a body.

    Parameters
    ----------
    link
        The number of the body; -1 is the base.
    rotation, position
        (3, 3) and (3,) in m, in the body's frame.
    """

    name: str
    link: int
    rotation: Array
    position: Array

    def __post_init__(self) -> None:
        check_name("Frame(name=...)", self.name)
        refuse_skewed(f"Frame({described(self.name)}, rotation=...)", self.rotation)
        vector(f"Frame({described(self.name)}, position=...)", self.position, 3, "coordinates")


def refuse_skewed(call: str, R: Array) -> None:
    """Refuse what is no rotation (3, 3); `call` names it.

    Raises
    ------
    ValueError
        If it is no matrix (3, 3), or its columns are not orthonormal, or left-handed.
    """
    matrix(call, R, 3, 3)
    gap = float(np.abs(R @ R.T - np.eye(3)).max())
    handed = float(np.cross(R[:, 0], R[:, 1]) @ R[:, 2])
    if not (gap <= ORTHONORMAL and handed > 0):
        raise ValueError(
            f"`{call}` must be orthonormal and right-handed, as its columns are the axes of a frame; R R' is {gap:.2g} "
            f"off the identity, det R {handed:.2g}."
        )


class Named(Protocol):
    """What has a name."""

    @property
    def name(self) -> str: ...  # noqa: D102


def frame_named(name: str, links: Sequence[Named], frames: Sequence[Frame]) -> Frame:
    """The frame of that name, given or a link's own; the last link's for an empty name.

    Raises
    ------
    LookupError
        If there is none; the message names the nearest.
    """
    for frame in frames:
        if name and frame.name == name:
            return frame
    own = [link.name for link in links]
    if name:
        known(name, [*(frame.name for frame in frames), *own], "frames of this arm")
    return Frame(name or own[-1], own.index(name) if name else len(own) - 1, np.eye(3), np.zeros(3))
