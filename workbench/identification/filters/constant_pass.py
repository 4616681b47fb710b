"""The pass of a filter with constant matrices, in which a covariance that repeats to its last bit is computed once.

The covariances do not depend on the samples. They settle, and in floating-point numbers they repeat after some steps.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.filters.array_steps import Correction, correction, predict
from workbench.identification.filters.forward_pass import AbstractPass, Mask, PassRecord, SensorNoise

MOST_NODES = 4096  # covariances that are remembered


class ConstantModel(NamedTuple):
    """x+ = A x + b_k + w, y = C x + d_k + v, with the root of cov w."""

    A: Array
    C: Array
    noise: Array
    b: Array  # (N, n)
    d: Array  # (N, q)


@dataclass(frozen=True, eq=False)
class _Node:
    """A root before a sample, and the steps from it, by the mask of the sensors that have a sample."""

    S: Array
    steps: dict[bytes, tuple[Correction | None, Array, _Node]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Nodes:
    """The roots that have occurred, by their bits."""

    model: ConstantModel
    sensors: SensorNoise
    nodes: dict[bytes, _Node] = field(default_factory=dict)

    def at(self, S: Array) -> _Node:
        """The node of a root."""
        if len(self.nodes) >= MOST_NODES:
            self.nodes.clear()
        return self.nodes.setdefault(S.tobytes(), _Node(S))

    def step(self, node: _Node, key: bytes, mask: Mask) -> tuple[Correction | None, Array, _Node]:
        """The correction by a sample, the root after it, and the node before the next sample."""
        if key not in node.steps:
            answer, S = None, node.S
            if mask.any():
                answer = correction(S, self.model.C.dot(S)[mask], self.sensors.root(mask))
                S = answer.S
            node.steps[key] = answer, S, self.at(predict(self.model.A.dot(S), self.model.noise))
        return node.steps[key]


def constant_pass(pass_: AbstractPass, model: ConstantModel, x: Array, S: Array, R: Array) -> PassRecord:
    """The same numbers as `forward_pass`, to the last bit."""
    N, q, n = len(pass_.y), pass_.outputs.size, pass_.states.size
    record = PassRecord.empty(N, n, q)
    seen, nodes = np.isfinite(pass_.y), _Nodes(model, SensorNoise(R))
    keys, counts = [mask.tobytes() for mask in seen], seen.sum(axis=1).tolist()
    node, (A, C, _, b, d) = nodes.at(S), model
    for k in range(N):
        record.x_predicted[k], record.S_predicted[k] = x, node.S
        answer, root, following = nodes.step(node, keys[k], seen[k])
        if answer is not None:
            innovation = record.innovations[k] = pass_.y[k] - (C.dot(x) + d[k])
            s = counts[k]
            whitened = answer.whiten(innovation if s == q else innovation[seen[k]])
            record.normalised_innovations[k, :s], record.roots[k, :s, :s] = whitened, answer.root
            x = x + whitened.dot(answer.gains)
        record.x[k], record.S[k] = x, root
        x = A.dot(x) + b[k]
        node = following
        if not np.isfinite(node.S[0, 0]):
            break
    return record
