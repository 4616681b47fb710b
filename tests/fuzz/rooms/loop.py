from __future__ import annotations

from functools import partial
from typing import Any

import control

from workbench.blocks import loop
from workbench.study.evidence.law_tables import information_table

from ..parts import LAW, LOOP, OBSERVER, PLANT, REFERENCE, signals

MODULES = ("workbench.blocks.loop",)
LINEAR = control.ss([[-1.0]], [[1.0]], [[2.0]], 0, inputs="v", outputs="omega")
GAUGES = loop.Instruments.of(PLANT, {"q": 0.1}, {"q": 0.1}, {"tau": (-1.0, 1.0)})


def calls() -> dict[str, Any]:
    return {
        "AbstractArmController": LAW,
        "AbstractArmObserver": OBSERVER,
        "AbstractController": LAW,
        "AbstractDisturbance": LOOP,
        "AbstractInstruments": GAUGES,
        "AbstractObserver": OBSERVER,
        "AbstractPlant": PLANT,
        "AbstractReference": REFERENCE,
        "ClosedLoop": partial(loop.ClosedLoop, PLANT, OBSERVER, LAW, REFERENCE),
        "Instruments": partial(
            loop.Instruments.of,
            PLANT,
            {"q": 0.1},
            {"q": 0.1},
            {"tau": (-1.0, 1.0)},
            {"q": (12, -4.0, 4.0, "down")},
            {"tau": (8, [-1.0, -2.0], 1.0)},
            (loop.RandomWalk("q", 0.1),),
        ),
        "AbstractNoise": loop.GaussMarkov("q", 0.1, 1.0),
        "GaussMarkov": partial(loop.GaussMarkov, "q", [0.1, 0.2], 1.0),
        "RandomWalk": partial(loop.RandomWalk, "q", [0.1, 0.2], 1.0),
        "SecondOrderNoise": partial(loop.SecondOrderNoise, "q", [0.1, 0.2], 10.0, 0.5),
        "DigitalLoop": partial(loop.DigitalLoop, LOOP, 1e-3, None, True),
        "LinearFilter": partial(loop.LinearFilter, LINEAR, ("v",)),
        "LinearLaw": partial(loop.LinearLaw, LINEAR, True, [1.0], [1.0]),
        "LinearPlant": partial(loop.LinearPlant, LINEAR, [1.0]),
        "Follows": loop.Follows,
        "Inputs": loop.Inputs,
        "Parts": loop.Parts,
        "Readings": partial(loop.Readings, PLANT.outputs),
        "Reads": loop.Reads,
        "Rest": partial(loop.Rest),
        "information_table": partial(information_table, "t", "c", {"a": LOOP.roles}, {"a": 3}),
        "open_loop": partial(loop.open_loop, PLANT, "plant"),
        "roles": partial(loop.roles, LOOP),
    }


def arguments() -> dict[str, Any]:
    return signals()
