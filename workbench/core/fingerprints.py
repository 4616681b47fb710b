"""Fingerprints: the digest of a function's operations and of all that they call, the same in every process."""

from __future__ import annotations

import hashlib

import casadi as ca

# The functions that a fingerprint can hold, by CasADi's names of their classes. It writes the first as C, with all that
# they call and all numbers to their last digit. What it writes of the others to a file is whole too, but changes with
# the derivatives of a spline in them that were asked for. Of all other functions, as of a callback in Python or a
# compiled library, it writes no more than a name or an address.
TABLES = {"LinearInterpolant", "LinearInterpolantJac", "BSplineInterpolant"}
WRITTEN_AS_C = {"SXFunction", "MXFunction", "Switch", "Map", "ThreadMap", "OmpMap", *TABLES}
ROOTS = {"Newton", "FastNewton", "KinsolInterface", "Qrqp", "Sqpmethod"}
INTEGRALS = {"RungeKutta", "Collocation", "CvodesInterface", "IdasInterface"}


def fingerprint_of(head: bytes, function: ca.Function) -> str:
    """The digest of some bytes and of the operations of an SX function (64 hexadecimal digits).

    Raises
    ------
    ValueError
        If the function calls one whose equations cannot be seen.
    """
    digest = hashlib.sha256(head)
    for line in _instructions(function):
        digest.update(repr(line).encode())
    return digest.hexdigest()


def _instructions(function: ca.Function) -> list[tuple[object, ...]]:
    """The operations in order, as plain tuples that print the same everywhere; then the places of sparse results."""
    lines: list[tuple[object, ...]] = []
    codes = [function.instruction_id(k) for k in range(function.n_instructions())]
    expressions = function.instructions_sx() if ca.OP_CALL in codes else None
    for k, code in enumerate(codes):
        value = function.instruction_constant(k).hex() if code == ca.OP_CONST else ""
        if expressions is not None and code == ca.OP_CALL:
            value = _fingerprint_of_called(expressions[k].which_function())
        lines.append((code, tuple(function.instruction_input(k)), tuple(function.instruction_output(k)), value))
    for i in range(function.n_out()):
        pattern = function.sparsity_out(i)
        if not pattern.is_dense():  # an operation counts the entries that are stored, wherever they stand
            lines.append(("sparse", i, pattern.shape, pattern.get_triplet()))
    return lines


def _fingerprint_of_called(function: ca.Function) -> str:
    """The digest of a called function: of its operations, or of all that CasADi writes of it."""
    parts = {part.class_name(): part.name() for part in (*function.find_functions(), function)}
    for kind, name in parts.items():
        if kind not in WRITTEN_AS_C | ROOTS | INTEGRALS:
            raise ValueError(
                f"The equations call '{name}', whose operations CasADi cannot show (a {kind}), so two loops that "
                "differ in it could not be told apart: write it as an expression or as a table."
            )
    if function.is_a("SXFunction"):
        shapes = [[sparsity.shape for sparsity in side(function)] for side in (_inputs, _outputs)]
        return fingerprint_of(repr(shapes).encode(), function)
    text = _code(function) if WRITTEN_AS_C.issuperset(parts) else function.serialize()
    return hashlib.sha256(text.encode()).hexdigest()


def _code(function: ca.Function) -> str:
    generator = ca.CodeGenerator("called")
    generator.add(function)
    return str(generator.dump())


def _inputs(function: ca.Function) -> list[ca.Sparsity]:
    return [function.sparsity_in(i) for i in range(function.n_in())]


def _outputs(function: ca.Function) -> list[ca.Sparsity]:
    return [function.sparsity_out(i) for i in range(function.n_out())]
