"""A model inside a law or an observer, and the stand-in that finds where equations have its functions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True, eq=False)
class Probe:
    """A block in place of a model: each function of its state is a symbol, by name, plus terms in its arguments."""

    block: object
    symbols: Mapping[str, ca.SX]


class AbstractModel(ABC):
    """A model whose functions of the state, as M, C and G of an arm, are told apart in the equations that use it."""

    @abstractmethod
    def probe(self) -> Probe:
        """A stand-in for the model."""
