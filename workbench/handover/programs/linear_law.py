"""A linear law as matrices: for python-control as text, for MATLAB as a file, which also holds other laws' names."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core.expressions import evaluate_sx
from workbench.core.layout import Entry, Layout
from workbench.core.linear import LinearSystem
from workbench.core.notation.comments import harmless
from workbench.core.notation.program import NAMES
from workbench.core.sampled_law import SampledLaw
from workbench.core.validation.refusals import Array, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.handover.export_seal import MARK, OPEN_SEAL, seal

REFERENCE_ENDING = "_ref"  # behind the name of a reference, as in `LinearLaw`
ONE = "one"  # the input that is 1
MAT_HEAD, MAT_TEXT = "MATLAB 5.0 MAT-file, ", 116  # bytes of text at the head of a MAT file, of any content
PORTS = ("inputs", "outputs", "states")
SIGNALS = ("z", "y", "r")


@dataclass(frozen=True, eq=False)
class _Affine:
    """A value as `gains` (n,) times the signals, plus a constant; or the reason for which it is none."""

    gains: Array
    constant: float
    reason: str = ""

    def scale(self, factor: float) -> _Affine:
        return _Affine(self.gains * factor, self.constant * factor, self.reason)

    def plus(self, other: _Affine) -> _Affine:
        return _Affine(self.gains + other.gains, self.constant + other.constant, self.reason or other.reason)

    @property
    def is_constant(self) -> bool:
        return not self.reason and not self.gains.any()


@check_arguments
def linear_law(law: SampledLaw, *, constants: str = "refused") -> LinearSystem:
    """The law as x+ = A x + B v, u = C x + D v with its period, where x is the memory and v readings and references.

    A reference has the ending '_ref'. The numbers of parameters are their defaults.

    Parameters
    ----------
    constants
        "refused", or "input" for one more input 'one', which is 1 at all times, where the law has constant terms, as
        about an operating point.

    Raises
    ------
    ValueError
        If the law is not linear: the message names the first result that is not, and the operation that it takes.
    """
    allowed = one_of("linear_law(constants=...)", constants, ("refused", "input")) == "input"
    results = _affine(law)
    labels = [f"{name} at the next instant" for name in law.memory.labels] + [*law.commands.labels]
    for label, result in zip(labels, results, strict=True):
        constant = "" if allowed or not result.constant else f"has the constant term {result.constant:g}"
        if result.reason or constant:
            raise ValueError(
                f"`linear_law(law)` must have a linear law; of '{law.name}' '{label}' {result.reason or constant}. "
                + ("Take it as C, or `linearize` the loop." if result.reason else "Take `constants='input'`.")
            )
    J = np.array([result.gains for result in results]) + 0.0  # of which no zero is negative
    nx = law.memory.size
    inputs = law.readings + Layout(
        tuple(replace(e, name=f"{e.name}{REFERENCE_ENDING}") for e in law.references.entries)
    )
    offsets = np.array([result.constant for result in results])
    if offsets.any():
        J, inputs = np.column_stack([J, offsets]), inputs + Layout((Entry(ONE, np.array(1.0)),))
    matrices: dict[str, Array] = {"D": J[nx:, nx:]}
    if nx:
        matrices |= {"A": J[:nx, :nx], "B": J[:nx, nx:], "C": J[nx:, :nx]}
    return LinearSystem(law.memory, inputs, law.commands, **matrices, dt=law.period)


@check_arguments
def as_control(law: SampledLaw) -> str:
    """The text of a module with the linear law as `law`, a `StateSpace` of python-control; see `linear_law`.

    A law with constant terms has the input 'one'.
    """
    system = linear_law(law, constants="input")
    nx, nu, ny = system.states.size, system.inputs.size, system.outputs.size
    shapes = {"A": (nx, nx), "B": (nx, nu), "C": (ny, nx), "D": (ny, nu)}
    head = [f'"""{harmless(law.name)}: a linear law that runs once in {law.period!r} s.', ""]
    head += [f"Made by {MARK}; the digest of its equations, period and numbers is {law.fingerprint[:16]}."]
    head += ['"""', "", "import control"]
    lines = [*head, "import numpy as np", ""]
    for letter, shape in shapes.items():
        matrix = getattr(system, letter)
        lines += [
            f"{letter} = np.array({np.asarray(matrix).tolist()!r})"
            if matrix is not None and matrix.size
            else f"{letter} = np.zeros({shape})"
        ]
    lines += [f"# The input '{ONE}' is 1 at all times."] if ONE in system.inputs else []
    lines += [f"START = {law.memory.default.tolist()!r}  # of the states", "", "law = control.ss(", "    A, B, C, D,"]
    lines += [f"    {law.period!r},"]
    for port in PORTS:
        names = [*getattr(system, port).labels]
        lines += [f"    {port}={names!r}," if names else ""]
    return "\n".join(line for line in [*lines, f"    name={_word(law.name)!r},", ")"] if line is not None) + "\n"


@check_arguments
def mat_of(law: SampledLaw) -> bytes:
    """A law as a file for MATLAB and Octave.

    A linear law has A, B, C, D, and where it has constant terms the last input 'one'; every law its period Ts, the
    names of its signals, its parameters and the start of its memory. `note` says which.
    """
    from scipy.io import savemat

    held: dict[str, object] = {"Ts": law.period, "name": law.name, "fingerprint": law.fingerprint, "made_by": MARK}
    for port in ("memory", "readings", "references", "commands", "parameters"):
        layout = getattr(law, port)
        held[f"{port}_names"] = np.array(layout.labels, dtype=object)
        if port in ("memory", "parameters"):
            held[port] = layout.default
    try:
        system = linear_law(law, constants="input")
        held |= {letter: np.asarray(part) for letter in "ABCD" if (part := getattr(system, letter)) is not None}
        held |= {f"{port}_names": np.array(getattr(system, port).labels, dtype=object) for port in PORTS}
        held["note"] = f"A, B, C and D of '{law.name}', its period Ts, its names and the start of its memory."
    except ValueError as error:
        held["note"] = f"No matrices: {error}"
    file = io.BytesIO()
    write: Callable[..., None] = savemat  # whose stub knows no open file
    write(file, held, oned_as="column")
    content = bytes(file.getvalue())
    head = f"{MAT_HEAD}{OPEN_SEAL}".encode().ljust(MAT_TEXT)
    return seal(head + content[MAT_TEXT:])


def _affine(law: SampledLaw) -> list[_Affine]:
    """Each result of a law, in its signals."""
    vectors = {letter: getattr(law, letter) for letter in SIGNALS}
    starts, size = {}, 0
    for letter, part in vectors.items():
        starts[letter], size = size, size + part.numel()
    made = ca.densify(ca.vertcat(law.update, law.command))
    made = ca.substitute([made], [law.p], [ca.SX(law.parameters.default)])[0]
    function = ca.Function("law", [*vectors.values(), law.k], [made])

    def source(part: int, entry: int) -> _Affine:
        if part == len(SIGNALS):
            return _Affine(np.zeros(size), 0.0, "takes the number of the instant")
        return _Affine(np.eye(size)[starts[SIGNALS[part]] + entry], 0.0)

    results = evaluate_sx(function, source, lambda value: _Affine(np.zeros(size), value), _operation)
    return [results[0][i] for i in range(made.numel())]


SUMS: Mapping[int, Callable[[_Affine, _Affine], _Affine]] = {
    ca.OP_ADD: lambda a, b: a.plus(b),
    ca.OP_SUB: lambda a, b: a.plus(b.scale(-1.0)),
}
SCALES = {ca.OP_NEG: -1.0, ca.OP_TWICE: 2.0, ca.OP_ASSIGN: 1.0}


def _operation(code: int, *operands: _Affine) -> _Affine:
    first, last = operands[0], operands[-1]
    if code in SUMS:
        return SUMS[code](first, last)
    if code in SCALES:
        return first.scale(SCALES[code])
    if code == ca.OP_MUL and (first.is_constant or last.is_constant):
        return last.scale(first.constant) if first.is_constant else first.scale(last.constant)
    if code == ca.OP_DIV and last.is_constant and last.constant:
        return _Affine(first.gains / last.constant, first.constant / last.constant, first.reason)
    earlier = next((operand.reason for operand in operands if operand.reason), "")
    name = NAMES.get(code, str(code))
    word = {"MUL": "the product of two signals", "SQ": "the square of a signal"}.get(
        name, f"the operation {name.lower()}"
    )
    return _Affine(first.gains * 0.0, 0.0, earlier or f"takes {word}")


def _word(name: str) -> str:
    return "".join(c if c.isalnum() and c.isascii() else "_" for c in name) or "law"
