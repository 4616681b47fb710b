"""The paper's figures 3 to 18, with our curves."""

from collections.abc import Sequence

from workbench.notation.formula import symbol
from workbench.study.document.document import Figure, Label
from workbench.study.pictures.traces import Window, components, traces
from workbench.study.study import Outcome

FIRST = {"FS": 3, "SS": 11}  # the number of each scenario's first figure in the paper
OBSERVED = {"FS": 9, "SS": 17}
ADAPTED = {"FS": 10, "SS": 18}
TORQUE = {"FS": (-60.0, 60.0), "SS": (-150.0, 150.0)}  # N m, what is shown of a torque
EARLY = 3.0  # s, where the left panel ends and the right one begins
CURVES = (  # signal, joint, letter, unit, words: six figures in the paper's order
    ("q", 0, "q_1", "rad", "Angle of joint 1"),
    ("e", 0, "e_1", "rad", "Tracking error of joint 1"),
    ("q", 1, "q_2", "rad", "Angle of joint 2"),
    ("e", 1, "e_2", "rad", "Tracking error of joint 2"),
    ("tau", 0, "tau_1", "N m", "Torque of joint 1"),
    ("tau", 1, "tau_2", "N m", "Torque of joint 2"),
)
GAINS = tuple((symbol(f"K_{i}{j}"), "controller.K", 2 * (i - 1) + j - 1) for i in (1, 2) for j in (1, 2))


def figures(shown: Sequence[Outcome], ours: Outcome, scenario: str, title: str) -> tuple[Figure, ...]:
    """All figures of one scenario: the laws, then the observer's errors and the gains of the proposed law."""
    return (
        *(_of_laws(shown, scenario, title, place) for place in range(len(CURVES))),
        _observer(ours, scenario, title),
        _gains(ours, scenario, title),
    )


def _windows(outcome: Outcome) -> tuple[Window, Window]:
    return Window(0, EARLY), Window(EARLY, float(outcome.t[-1]))


def _of_laws(shown: Sequence[Outcome], scenario: str, title: str, place: int) -> Figure:
    signal, joint, letter, unit, words = CURVES[place]
    number = FIRST[scenario] + place
    caption = f"{words}, {title} (the paper's figure {number})."
    early, late = _windows(shown[0])
    if signal == "tau":
        early = Window(early.start, early.end, TORQUE[scenario])
        late = Window(late.start, late.end, TORQUE[scenario]) if scenario == "SS" else late
        caption += " What leaves the frame is in the tables as peak torque."
    return traces(
        f"{scenario.lower()}_figure_{number}",
        caption,
        shown,
        signal,
        joint,
        _label(letter, unit),
        (early, late),
        reference="q_ref" if signal == "q" else "",
    )


def _observer(ours: Outcome, scenario: str, title: str) -> Figure:
    number = OBSERVED[scenario]
    return components(
        f"{scenario.lower()}_figure_{number}",
        (
            "Estimation errors ",
            symbol("q"),
            " - ",
            symbol("q_hat"),
            f" of (10), {title} (the paper's figure {number}).",
        ),
        ours,
        ((symbol("q_1"), "q_error", 0), (symbol("q_2"), "q_error", 1)),
        "estimation error [rad]",
        _windows(ours),
    )


def _gains(ours: Outcome, scenario: str, title: str) -> Figure:
    number = ADAPTED[scenario]
    return components(
        f"{scenario.lower()}_figure_{number}",
        ("Gains ", symbol("K"), f" of the repaired law, {title} (the paper's figure {number})."),
        ours,
        GAINS,
        _label("K", "N m"),
        _windows(ours),
    )


def _label(letter: str, unit: str) -> Label:
    return (symbol(letter), f" [{unit}]")
