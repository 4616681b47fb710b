"""The result of a PID design: gains, what they promise, and the law as a system of python-control."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.point import OperatingPoint
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import finite
from workbench.design.control_system import System
from workbench.design.frequency.margin_records import StabilityMargins
from workbench.design.frequency.stability_margins import stability_margins
from workbench.design.pid_design.load_response import integral_absolute_error
from workbench.design.pid_design.noise_gain import noise_gain
from workbench.design.pid_design.process import Process
from workbench.design.pid_design.reference_weight import ReferenceResponse

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
@show
class PeakContact:
    """A frequency in rad/s at which the peak of S or T, `function`, is at its limit."""

    function: str
    frequency: float


@dataclass(frozen=True, eq=False)
@show
class PidDesign:
    """A PI or PID law for a plant with a delay in s:

        u = k (b r - y) + ki/s (r - y) + kd s / (1 + s/N) (c r - y),

    which is the law of `wb.PID`; `wb.PID.of(design)` makes one. N, in rad/s, is None for a PI law. k has the unit of
    u over the unit of y, ki that over s, and kd that times s.

    `Ms` and `Mt` are the limits that were asked for, infinite for none. The `certificate` has the margins of the loop,
    each with its bounds, by `stability_margins`, which shares no code with the design. `bound` is an upper bound of ki
    for all laws of this form with this kd within the limits; for the least IAE it is the one with the kd of the largest
    ki. `contacts` are the frequencies at which the limits are met, for the least IAE approximately. A rule has neither.
    `remarks` say what was asked for and is not met.
    """

    method: str
    k: float
    ki: float
    kd: float
    N: float | None
    b: float
    c: float
    Ms: float
    Mt: float
    certificate: StabilityMargins
    bound: float | None
    contacts: tuple[PeakContact, ...]
    plant: System
    delay: float
    remarks: tuple[str, ...] = ()

    @property
    def form(self) -> str:
        """PI or PID."""
        return "PI" if self.N is None else "PID"

    @property
    def Ti(self) -> float:
        """The integral time k / ki in s."""
        return self.k / self.ki if self.ki else np.inf

    @property
    def Td(self) -> float:
        """The derivative time kd / k in s."""
        return self.kd / self.k if self.k else np.inf

    @property
    def IE(self) -> float:
        """The integral of the error after a unit step of load at the input of the plant, 1 / ki."""
        return 1 / self.ki if self.ki else np.inf

    @property
    def IAE(self) -> float:
        """The integral of the absolute error after a unit step of load at the input of the plant."""
        return integral_absolute_error(self.plant, self.delay, self.loop_filter).value

    @property
    def IAE_error(self) -> float:
        """An estimate of the error of IAE, by half the frequencies and half the times; IAE is refused above 2 %."""
        return integral_absolute_error(self.plant, self.delay, self.loop_filter).error

    @property
    def noise_gain(self) -> float:
        """The peak over frequency of the gain |C S| from noise of the measurement to u."""
        return noise_gain(self.plant, self.delay, self.loop_filter)

    @property
    def reference_response(self) -> ReferenceResponse:
        """The response from the reference to the output, by the parts of the law."""
        process = Process.of("tune_pid", self.plant, self.delay)
        return ReferenceResponse.of(process, self.k, self.ki, self.kd, self.N)

    @property
    def reference_peak(self) -> float:
        """The peak of |y/r| with the weights b and c."""
        return self.reference_response.peak(self.b, self.c)

    @property
    def loop_filter(self) -> control.TransferFunction:
        """The law from the error to u, with all weights one."""
        return law_of_error(self.k, self.ki, self.kd, self.N, self.plant)

    @property
    def controller(self) -> control.StateSpace:
        """The law from y and y_ref to u, with the feedback sign inside: `ClosedLoop` takes it as it stands.

        For a linearised plant it is relative to the operating point, as that of `lqg`.
        """
        return _controller(self)

    @property
    def law_arguments(self) -> dict[str, object]:
        """The arguments of `wb.PID`; for a linearised plant with its layouts and its operating point."""
        from workbench.design.linear.pointed_systems import point_of

        gains = {"Kp": self.k, "Ki": self.ki, "Kd": None if self.N is None else self.kd, "N": self.N}
        weights: dict[str, object] = {"b": self.b, "c": self.c}
        point = point_of(self.plant)
        if point is None:
            return gains | weights
        u0 = point.u0 + self.k * (1 - self.b) * point.y0  # so that v is u0 at rest, with b below 1 too
        return gains | weights | {"reads": point.outputs, "drives": point.inputs, "u0": u0, "y0": point.y0}

    def with_weights(self, b: float, c: float) -> PidDesign:
        """The same design with other weights of the reference."""
        b, c = finite("PidDesign.with_weights(b=...)", b), finite("PidDesign.with_weights(c=...)", c)
        return replace(self, b=b, c=c)


def law_of_error(k: float, ki: float, kd: float, N: float | None, plant: System) -> control.TransferFunction:
    """k + ki/s + kd s/(1 + s/N), named for a plant."""
    import control

    names = {"inputs": plant.output_labels, "outputs": plant.input_labels, "name": f"PID of {plant.name}"}
    if N is None:
        return control.tf([k, ki], [1, 0], **names)
    return control.tf([k + kd * N, k * N + ki, ki * N], [1, N, 0], **names)


def loop_of(plant: System, law: control.TransferFunction) -> System:
    """The loop gain of a plant without its delay and a law of the error; a `StateSpace` keeps its hidden modes."""
    import control

    if isinstance(plant, control.StateSpace):
        return control.ss(plant) * control.ss(law)
    num = np.polymul(plant.num[0][0], law.num[0][0])
    return control.tf(num, np.polymul(plant.den[0][0], law.den[0][0]))


def certificate_of(plant: System, delay: float, law: control.TransferFunction) -> StabilityMargins:
    """The margins of a plant and a law, proved from the doubles of their coefficients."""
    return stability_margins(loop_of(plant, law), delay)


def _controller(design: PidDesign) -> control.StateSpace:
    import control

    from workbench.design.linear.pointed_systems import PointedSpace, point_of

    k, ki, kd, N, b, c = design.k, design.ki, design.kd, design.N, design.b, design.c
    A, B, C, D = [[0.0]], [[-ki, ki]], [[1.0]], [[-k, k * b]]
    states = ["integral"]
    if N is not None:
        A, B, C = [[0.0, 0.0], [0.0, -N]], [*B, [-N, N * c]], [[1.0, -kd * N]]
        D, states = [[-k - kd * N, k * b + kd * N * c]], ["integral", "filter"]
    plant = design.plant
    (output,), (drive,) = plant.output_labels, plant.input_labels
    system = control.ss(
        A,
        B,
        C,
        D,
        name=f"{design.form} of {plant.name}",
        states=states,
        inputs=[output, f"{output}_ref"],
        outputs=[drive],
        remove_useless_states=False,
    )
    point = point_of(plant)
    return system if point is None else PointedSpace(system, _point(point, states))


def _point(point: OperatingPoint, states: list[str]) -> OperatingPoint:
    """The point of a law that reads y and its reference."""
    (entry,) = point.outputs.entries
    units = {"integral": point.inputs.entries[0].unit, "filter": entry.unit}
    both = Layout((entry, replace(entry, name=f"{entry.name}_ref")))
    own = point.of_controller(Layout(tuple(Entry(name, np.zeros(()), units[name]) for name in states)))
    return replace(own, inputs=both, u0=np.concatenate([own.u0, own.u0]))
