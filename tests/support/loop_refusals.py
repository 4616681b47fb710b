"""A refusal held to its words, and a plant whose names are chosen."""

import pytest

import workbench as wb


def refused(make, *says, error=ValueError):
    """The one sentence or two of a refusal, with all that they must say."""
    with pytest.raises(error) as refusal:
        make()
    text = str(refusal.value)
    assert all(each in text for each in says), text
    assert "\n" not in text
    return text


def plant(inputs, outputs, start="m", **own):
    """A plant with the state x, and the parameter k."""
    fields = {
        "__annotations__": {"x": float, "k": float},
        "x": wb.initial(default=1.0, unit=start),
        "k": wb.parameter(default=1.0, unit="1/s"),
        "inputs": inputs,
        "outputs": outputs,
        "rate": lambda self, t, x, u: {"x": u[inputs.names[0]] - self.k * x.x},
    }
    return wb.block(type("Own", (wb.Plant,), {**fields, **own}))()
