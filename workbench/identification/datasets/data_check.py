"""`check_data`: the questions that a log must answer before any fit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from workbench.core import Ode
from workbench.core.equations import Loop, equations_of
from workbench.core.sampled_system import SampledSystem
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array, positive, text, vector
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets.data_finding import SEVERITIES, DataFinding
from workbench.identification.datasets.dataset import Dataset
from workbench.identification.datasets.signal_checks import (
    check_constant,
    check_excitation,
    check_missing,
    check_outliers,
    check_saturated,
    check_wrapped,
)
from workbench.identification.datasets.system_checks import (
    check_length,
    check_names,
    check_system_names,
    check_units,
    expected_units,
)
from workbench.identification.datasets.time_checks import check_times

SAMPLES = 3  # numbers of the outputs for each parameter, at least


@dataclass(frozen=True)
@check_arguments
class DataCheck:
    """The points of a check of data, and the answers of the user.

    Parameters
    ----------
    findings
        The points that are not answered: first those that refuse the data, then questions, then remarks.
    answers
        The answers by the names of their points.
    answered_findings
        The questions that were answered.
    """

    findings: tuple[DataFinding, ...]
    answers: Mapping[str, str] = field(default_factory=dict)
    answered_findings: tuple[DataFinding, ...] = ()

    @property
    def open_findings(self) -> tuple[DataFinding, ...]:
        """The points in the way of a fit: those that refuse the data, and questions without an answer."""
        return tuple(one for one in self.findings if one.severity != "remark")

    @property
    def is_passed(self) -> bool:
        """True if nothing is refused and no question is open."""
        return not self.open_findings

    @check_arguments
    def answer(self, answers: Mapping[str, str]) -> DataCheck:
        """The check without the questions that are answered; the answers are kept for the report.

        Parameters
        ----------
        answers
            By a point, 'saturated signal', or by a point of one signal, 'saturated signal: y', a sentence.

        Raises
        ------
        LookupError
            If there is no such point.
        ValueError
            If a point refuses the data, which no answer changes, or an answer is empty.
        """
        rest = list(self.findings)
        done = []
        for name, sentence in answers.items():
            text(f"DataCheck.answer({{{name!r}: ...}})", sentence)
            points = [one for one in rest if name in (one.point, one.name)]
            if not points:
                names = ", ".join(f"'{one.name}'" for one in rest if one.severity == "question") or "none"
                raise LookupError(f"There is no point '{name}' to answer. The open questions are: {names}.")
            if refused := [one for one in points if one.severity == "refused"]:
                raise ValueError(
                    f"`DataCheck.answer(...)` must be to a question; '{refused[0].name}' refuses the data, which no "
                    f"answer changes. {refused[0].text}"
                )
            rest = [one for one in rest if one not in points]
            done += points
        return DataCheck(tuple(rest), {**self.answers, **answers}, (*self.answered_findings, *done))

    def require(self) -> None:
        """Raise a ValueError with all open points, one a line, if there are any."""
        if not self.is_passed:
            lines = "\n".join(f"- {one}" for one in self.open_findings)
            raise ValueError(f"The data did not pass their check; mend or answer each point:\n{lines}")

    def __repr__(self) -> str:
        counts = {word: sum(one.severity == word for one in self.findings) for word in SEVERITIES}
        parts = [
            f"{count} {word}{'s' if count > 1 and word != 'refused' else ''}" for word, count in counts.items() if count
        ]
        parts += [f"{len(self.answered_findings)} answered"] if self.answered_findings else []
        return f"<DataCheck: {'passed' if self.is_passed else 'not passed'}{''.join(f', {part}' for part in parts)}>"

    def __str__(self) -> str:
        answered = [f"answered, {name}. {sentence}" for name, sentence in self.answers.items()]
        return "\n".join([*map(str, self.findings), *answered]) or "Nothing was found."

    def _repr_html_(self) -> str:
        rows = [(one.severity, one.name, one.text) for one in self.findings]
        rows += [("answered", name, sentence) for name, sentence in self.answers.items()]
        return table_to_html(repr(self)[1:-1], ("severity", "point", "sentence"), rows)


@check_arguments
def check_data(
    dataset: Dataset,
    *,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    system: Ode | SampledSystem | Loop | None = None,
    parameters: Sequence[str] = (),
    rate: float | None = None,
    units: Mapping[str, str] | None = None,
    x: Array | None = None,
    p: Array | None = None,
) -> DataCheck:
    """The check of a log before a fit: time, gaps, units, length, excitation, and samples that cannot be right.

    A log whose check is not passed is not fitted: what is refused must be mended, and a question must be answered.

    Parameters
    ----------
    dataset
        The log.
    inputs, outputs
        The signals that drive the system, and those with which it answers; by default the ones that the system names.
    system
        The loop or `Ode` to be fitted. Names and units are compared with it, and the length with its slowest mode.
    parameters
        The parameters to be fitted; their number says how much excitation and how many samples are needed.
    rate
        The stated sampling rate in Hz, which shows if the times are in another unit than s.
    units
        The units that signals must have, by name, beside those of the system.
    x, p
        The point of the slowest mode: a state (nx,) and parameters (np,); by default those of the system.

    Raises
    ------
    ValueError
        If the rate is not positive, or x or p do not fit the system.

    Examples
    --------
    >>> t = np.linspace(0.0, 10.0, 501)
    >>> log = wb.Dataset.of(t, {"u": np.sign(np.sin(t)), "y": np.minimum(np.sin(t), 0.8)}, {"u": "V", "y": "m"})
    >>> check = wb.check_data(log, inputs=["u"], outputs=["y"])
    >>> check
    <DataCheck: not passed, 1 question>
    >>> check.answer({"saturated signal": "the sensor ends at 0.8 m"}).is_passed
    True
    """
    if rate is not None:
        positive("check_data(rate=...)", rate, " of Hz")
    equations = None if system is None else equations_of(system, "system")
    model = equations.flow if isinstance(equations, SampledSystem) else equations
    inputs, outputs = _ports(dataset, model, inputs, outputs)
    findings = [*_of_names(dataset, model, inputs, outputs, units)]
    here = [[name for name in names if _is_here(dataset, name)] for names in (inputs, outputs)]
    findings += _of_samples(dataset, here[0], here[1], rate)
    findings += _of_amounts(dataset, here[0], here[1], len(parameters))
    if isinstance(equations, Ode):
        findings += _of_length(dataset, equations, x, p)
    return DataCheck(tuple(sorted(dict.fromkeys(findings), key=lambda one: SEVERITIES.index(one.severity))))


def _of_length(dataset: Dataset, system: Ode, x: Array | None, p: Array | None) -> Iterable[DataFinding]:
    """The points of the slowest mode at a state and parameters of the right sizes."""
    state = None if x is None else vector("check_data(x=...)", x, system.states.size, "states")
    numbers = None if p is None else vector("check_data(p=...)", p, system.parameters.size, "parameters")
    yield from check_length(dataset, system, state, numbers)


def _of_names(
    dataset: Dataset,
    model: Ode | None,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    units: Mapping[str, str] | None,
) -> Iterable[DataFinding]:
    """The points of names and units."""
    yield from check_names(dataset, inputs, "input")
    yield from check_names(dataset, outputs, "output")
    if model is not None:
        yield from check_system_names(model, inputs, outputs)
    yield from check_units(dataset, (*inputs, *outputs), expected_units(model, (*inputs, *outputs), units))


def _ports(
    dataset: Dataset, model: Ode | None, inputs: Sequence[str], outputs: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    names = dataset.signals.names
    if model is not None:
        inputs = inputs or tuple(model.inputs)
        known = (*model.outputs.names, *model.states.names)
        outputs = outputs or tuple(name for name in names if name in known and name not in inputs)
    return tuple(inputs), tuple(outputs or (name for name in names if name not in inputs))


def _is_here(dataset: Dataset, name: str) -> bool:
    return name in dataset.signals.names or name in dataset.signals.labels


def _of_samples(dataset: Dataset, inputs: list[str], outputs: list[str], rate: float | None) -> Iterable[DataFinding]:
    """The points of times and samples of each experiment."""
    for experiment in dataset:
        yield from check_times(experiment, rate)
        driving = experiment.columns(inputs) if inputs else ()
        answering = experiment.columns(outputs) if outputs else ()
        for column in (*driving, *answering):
            yield from check_missing(experiment, column, column in driving)
            yield from check_constant(experiment, column, driving)
        for column in answering:
            yield from check_saturated(experiment, column)
            yield from check_wrapped(experiment, column)
            yield from check_outliers(experiment, column)


def _of_amounts(dataset: Dataset, inputs: list[str], outputs: list[str], unknowns: int) -> Iterable[DataFinding]:
    """The number of samples, and the excitation, for a number of parameters."""
    columns = dataset.experiments[0].columns(outputs) if outputs else ()
    count = sum(int(experiment.is_weighed[:, list(columns)].sum()) for experiment in dataset)
    if unknowns and count < SAMPLES * unknowns:
        sentence = (
            f"The log must have at least {SAMPLES} numbers of its outputs for each of {unknowns} parameters, and is "
            f"too short with {count}: record a longer one, or find fewer parameters."
        )
        yield DataFinding("too short", "refused", sentence)
    elif unknowns and inputs and count:
        places = dataset.experiments[0].columns(inputs)
        yield from check_excitation(dataset.experiments, places, inputs, unknowns)
