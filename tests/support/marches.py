"""A loop in its computer, marched by hand."""

import numpy as np


def marched(step, noise):
    x, rows = step.states.default, []
    for k, w in enumerate(noise):
        x = np.array(step.F(k, x, step.parameters.default, w)).ravel()
        rows.append(x)
    return np.array(rows)
