"""The linear answers of a loop at many rows of parameters and states at once; a row without an answer is flagged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.core import SampledSystem
from workbench.core.validation.number_types import Numbers, Values
from workbench.core.validation.refusals import Array, as_array
from workbench.core.validation.signatures import check_arguments
from workbench.core.views import NotebookPicture, picture_of
from workbench.design.frequency.frequency_axis import checked_frequencies
from workbench.design.linear_loop.cut_margins import refuse_rates
from workbench.design.linear_loop.frequency_answers import CutModels, FrequencyResponse
from workbench.design.linear_loop.loop_equations import Equations, split_values
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.linear_loop.loop_point import LoopPoint, opened_rows, point_models, without_corners
from workbench.design.linear_loop.loop_remarks import doubt_of
from workbench.design.linear_loop.rest_state import Mask, find_rest, motion_sentences, resting_states
from workbench.design.linear_loop.row_margins import RowMargins, row_margins
from workbench.design.matrices import EPS, Complex, DesignError

CALL = "LinearLoop.rows"


@dataclass(frozen=True, eq=False)
class LinearRows:
    """A loop that is linear at N rows of states x (N, nx) and parameters p (N, np), as `LinearLoop.rows` makes it.

    `reasons` says why a row has no answer, by its number; the numbers of such a row are NaN. `point` is the one from
    which the rows differ, and `varied_values` has the values (N,) of each number that was named.
    """

    x: Array
    p: Array
    models: CutModels
    reasons: Mapping[int, str]
    point: LoopPoint
    varied_values: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.x)

    @property
    def flagged_rows(self) -> Mask:
        """True for each row without an answer, (N,)."""
        return np.isin(np.arange(len(self)), list(self.reasons))

    @property
    def poles(self) -> Complex:
        """The poles of the closed loop of each row, (N, nx), the slowest first; NaN in rows that are flagged."""
        return self._poles[0]

    @property
    def stable(self) -> Mask:
        """True for each row whose poles all decay, by more than rounding may have moved them, (N,)."""
        return self._poles[1]

    @check_arguments
    def response(
        self,
        frequencies: Array,
        of: str = "L",
        inputs: str | tuple[str, ...] | None = None,
        outputs: str | tuple[str, ...] | None = None,
    ) -> FrequencyResponse:
        """The frequency response (N, m, ny, nu) of N rows, see `LinearLoop.response`; a row with a pole is flagged."""
        call, names = "LinearRows.response", [(n,) if isinstance(n, str) else n for n in (inputs, outputs)]
        omega = checked_frequencies(f"{call}(frequencies=...)", frequencies, self.models.closed_model.period)
        found, seen, shown = self.models.response(call, of, omega, *names)
        flagged = np.asarray(~np.isfinite(found.values).all(axis=(1, 2, 3)))
        return FrequencyResponse(omega, found.values, seen, shown, flagged, found.errors, found.sensitivities)

    @cached_property
    def margins(self) -> RowMargins:
        """The margins of each row at each signal at which the loop is cut, see `RowMargins`; NaN in unstable rows.

        Raises
        ------
        ValueError
            If the loop has a delay in continuous time, blocks at several periods, or no cut.
        """
        call = "LinearRows.margins"
        if self.models.delays.any():
            raise ValueError(
                f"`{call}` needs loops without delays; take `LinearLoop.margins` of single rows, or a `PadeDelay` of "
                "`EquippedPlant` in the place of a delay."
            )
        refuse_rates(call, self.models)
        opened = self.models.open_drives(call)
        return row_margins(call, self.models, [opened.outputs[i] for i in self.models.channels], self.stable)

    def plot(self, kind: str = "", **options: object) -> NotebookPicture:
        """A picture over all rows: the median, the middle 90 % and the range, and the worst row by its name.

        Parameters
        ----------
        kind
            "bode", the default for one channel (`at` names one of several; `of`, `inputs` and `outputs` name another
            response); "sensitivity", the default for several channels: the largest gain of S; "step" (`inputs`,
            `outputs`, `until` in s); or "poles".
        options
            `frequencies` (m,) in rad/s, `bounds` of gains, and the options named above.

        Raises
        ------
        ValueError
            If there is no such kind, an option does not fit, or the loop has a delay and therefore no such picture.
        """
        return picture_of(self, kind, **options)

    def __repr__(self) -> str:
        return f"<{len(self)} rows of a LinearLoop, {len(self.reasons)} flagged>"

    @cached_property
    def _poles(self) -> tuple[Complex, Mask]:
        if self.models.delays.any():
            raise DesignError(
                "`LinearRows.poles` needs a finite number of states, and a delay has infinitely many. Use `response`, "
                "which is exact, or replace the delay by a `PadeDelay` of `EquippedPlant`."
            )
        A, discrete = self.models.closed_model.A, self.models.closed_model.period is not None
        poles, stable, n = np.full(A.shape[:2], np.nan, complex), np.zeros(len(A), dtype=bool), A.shape[1]
        for i in np.flatnonzero(np.isfinite(A).all(axis=(1, 2))):
            values, right = np.linalg.eig(A[i])
            growth = np.abs(values) - 1 if discrete else values.real
            poles[i] = values[np.lexsort((-values.imag, -np.round(growth, 9)))]
            try:
                condition = np.linalg.norm(np.linalg.inv(right), axis=1)
            except np.linalg.LinAlgError:  # a defective pole
                condition = np.full(n, 1 / EPS)
            stable[i] = (growth < -doubt_of(condition, float(np.linalg.norm(A[i], 2)), n)).all()
        return poles, stable


def linear_rows(point: LoopPoint, corner_signals: tuple[str, ...], values: Values) -> LinearRows:
    """The linear loops at rows of values by name, each at its own rest if the point is one."""
    equations, closed = point.equations, point.equations.closed_loop
    x, p, fixed, reasons = _rows(closed, values, point)
    sound = _sound(len(x), reasons)
    made, cut = point.row_models
    if point.at_rest:
        must = resting_states(closed, equations.ports)
        rest, share = find_rest(made.motion, x[sound], p[sound], must, fixed, isinstance(closed, SampledSystem))
        x[sound] = rest
        sentences = motion_sentences(CALL, closed, point.instant, rest, p[sound], share, must)
        reasons |= {i: sentence for i, sentence in zip(sound, sentences, strict=True) if sentence}
        sound = _sound(len(x), reasons)
    closed_model, output, cornered = made.model(x[sound], p[sound])
    opened_model = None
    if cut is not None:
        opened_model, _, also = cut.model(x[sound], opened_rows(equations, p[sound], output))
        cornered = cornered | also
    pair = (closed_model, opened_model)
    _put_pieces(point, x[sound], p[sound], np.flatnonzero(cornered).tolist(), pair, sound, reasons)
    full = [
        None if model is None else _spread_rows(without_corners(model, corner_signals), sound, len(x), reasons)
        for model in pair
    ]
    assert full[0] is not None
    models = CutModels(full[0], full[1], equations.channels, np.array(equations.delays))
    return LinearRows(x, p, models, dict(sorted(reasons.items())), point, _varied_values(closed, values, len(x)))


def _rows(closed_loop: Equations, values: Values, point: LoopPoint) -> tuple[Array, Array, list[int], dict[int, str]]:
    """States and parameters of each row, the places of named states, and the rows whose values are refused."""
    reasons: dict[int, str] = {}
    try:
        x, p, fixed = split_values(CALL, closed_loop, values)
    except ValueError:
        columns = {name: _column(closed_loop, name, value) for name, value in values.items()}
        counts = {len(column) for column in columns.values() if column is not None}
        if len(counts) != 1:
            raise
        x, p, fixed, reasons = _row_by_row(closed_loop, values, columns, counts.pop())
        if len(reasons) == len(x):
            raise
    for layout, rows, own in ((closed_loop.states, x, point.x), (closed_loop.parameters, p, point.p)):
        named = {i for name in values if name in layout or name in layout.labels for i in layout.indices(name)}
        rest = [i for i in range(layout.size) if i not in named]
        rows[:, rest] = own[rest]
    return x, p, fixed, reasons


def _varied_values(closed_loop: Equations, values: Values, count: int) -> dict[str, Array]:
    """The values (N,) of each number by its name that has one for each row."""
    columns = {name: _column(closed_loop, name, value) for name, value in values.items()}
    return {name: column.ravel() for name, column in columns.items() if column is not None and column.size == count}


def _column(closed_loop: Equations, name: str, value: Numbers) -> Array | None:
    """The value as an array with an entry for each row, or None if it is one value for all rows."""
    layout = closed_loop.states if name in closed_loop.states else closed_loop.parameters
    shape = layout[name].shape if name in layout else ()
    array = as_array(value)
    return array if array is not None and array.shape[1:] == shape and array.shape != shape else None


def _row_by_row(
    closed_loop: Equations, values: Values, columns: Mapping[str, Array | None], count: int
) -> tuple[Array, Array, list[int], dict[int, str]]:
    """The rows, where those that are refused take the defaults of the loop, with the reason of each."""
    x, p = np.tile(closed_loop.states.default, (count, 1)), np.tile(closed_loop.parameters.default, (count, 1))
    reasons, fixed = dict[int, str](), list[int]()
    for i in range(count):
        row = {name: value if (own := columns[name]) is None else own[i] for name, value in values.items()}
        try:
            one_x, one_p, fixed = split_values(CALL, closed_loop, row)
            x[i], p[i] = one_x[0], one_p[0]
        except ValueError as error:
            reasons[i] = str(error)
    return x, p, fixed, reasons


def _sound(count: int, reasons: Mapping[int, str]) -> list[int]:
    """The rows without a reason; if there is none, the first reason is raised."""
    rows = [i for i in range(count) if i not in reasons]
    if not rows:
        raise ValueError(f"`{CALL}(values=...)` must leave a row that has an answer; of the first: {reasons[0]}")
    return rows


def _put_pieces(
    point: LoopPoint,
    x: Array,
    p: Array,
    corner_rows: list[int],
    models: tuple[LoopModel, LoopModel | None],
    places: list[int],
    reasons: dict[int, str],
) -> None:
    """Put the models of rows on a corner, one by one, in the place of those that the kernel made of no piece."""
    for i in corner_rows:
        try:
            own = point_models(CALL, point, x[i], p[i])
        except ValueError as error:
            reasons[places[i]] = str(error)
            continue
        for model, one in zip(models, own, strict=True):
            if model is not None and one is not None:
                for whole, part in zip(_matrices(model), _matrices(one.model), strict=True):
                    whole[i] = part[0]


def _spread_rows(model: LoopModel, places: list[int], count: int, reasons: dict[int, str]) -> LoopModel:
    """The model of all rows: NaN in those that are left out or have a reason, or where a Jacobian is not finite."""
    sound = np.all([np.isfinite(M).all(axis=(1, 2)) for M in _matrices(model)], axis=0)
    for place in (places[i] for i in np.flatnonzero(~sound)):
        reasons.setdefault(place, f"`{CALL}(...)`: a Jacobian of this row is not finite.")
    kept = np.array([i for i, place in enumerate(places) if place not in reasons], dtype=int)
    wide = []
    for M in _matrices(model):
        wide.append(np.full((count, *M.shape[1:]), np.nan))
        wide[-1][np.array(places)[kept]] = M[kept]
    A, B, Cy, D = wide
    return replace(model, A=A, B=B, Cy=Cy, D=D)


def _matrices(model: LoopModel) -> tuple[Array, Array, Array, Array]:
    return model.A, model.B, model.Cy, model.D
