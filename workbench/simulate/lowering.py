"""Lowering: a plan as LLVM IR, the whole time loop in one function over vectors of runs.

The function advances one block of `width` runs, each state a vector of doubles:

    void workbench_march(i64 kept, i64 stride, ptr x, ptr lanes, ptr uniform, ptr table, ptr out)

`x` holds the states (nx, width) and receives them again; `lanes` the values made once a run (nl, width),
`uniform` those equal in all runs (nu), `table` those made once a step (kept * stride, nt); `out`
receives the states after every `stride` steps, (kept, nx, width).
"""

from __future__ import annotations

from collections.abc import Iterator

from workbench.simulate import functions as f
from workbench.simulate.plan import Plan

TRUTHS = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul"}
UNARY = {"sqrt": "sqrt", "fabs": "fabs", "floor": "floor"}
# Numbers that stand in the IR. All others are handed in, so that a step and its half are one kernel.
PLAIN = (0.0, 1.0, -1.0, 2.0, 0.5)
COMPOSED = {"exp": f.exponential, "tanh": f.hyperbolic_tangent, "log": f.logarithm}


def lower(plan: Plan, width: int) -> str:
    """The IR of a plan for vectors of `width` runs.

    Raises
    ------
    ValueError
        If an operation inside the loop has no lowering; the message names it.
    """
    return _Loop(plan, width).text()


class _Loop:
    """Writes the function line by line; every value is a vector over the runs of a block."""

    def __init__(self, plan: Plan, width: int) -> None:
        self.plan = plan
        self.width = width
        self.type = f"<{width} x double>"
        self.integers = f"<{width} x i64>"
        self.lines: list[str] = []
        self.values: dict[int, str] = {}
        self.truths: dict[int, str] = {}
        self.angles: dict[int, tuple[str, str, str]] = {}
        self.inside = set(plan.inside)

    # what `functions` needs of a writer

    def line(self, text: str) -> str:
        """One instruction; its name."""
        name = f"%v{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return name

    def vector(self, value: float) -> str:
        """A constant in every lane."""
        return f"<{', '.join([f'double {f.literal(value)}'] * self.width)}>"

    def whole(self, value: int) -> str:
        """A whole number in every lane."""
        return f"<{', '.join([f'i64 {value}'] * self.width)}>"

    # the function

    def text(self) -> str:
        """All of the IR."""
        nx, nt = len(self.plan.graph.results), len(self.plan.table)
        body = self._body()
        phis = (f"  %x{i} = phi {self.type} [ %first{i}, %enter ], [ %y{i}, %step ]" for i in range(nx))
        intrinsics = (
            f"declare {self.type} @llvm.{name}.{f.mangled(self)}({', '.join([self.type] * count)})"
            for name, count in (("fma", 3), ("sqrt", 1), ("fabs", 1), ("floor", 1), ("trunc", 1), ("copysign", 2))
        )
        signature = "i64 %kept, i64 %stride, ptr %x, ptr %lanes, ptr %uniform, ptr %table, ptr %out"
        return "\n".join(
            [
                *intrinsics,
                f'define void @workbench_march({signature}) alignstack(64) "stackrealign" {{',
                "start:",
                "  br label %outer",
                "outer:",
                "  %j = phi i64 [ 0, %start ], [ %j1, %store ]",
                "  %done = mul i64 %j, %stride",
                "  br label %enter",
                "enter:",
                *self._loads("first", "%x", nx),
                "  br label %step",
                "step:",
                "  %i = phi i64 [ 0, %enter ], [ %i1, %step ]",
                *phis,
                "  %k = add i64 %done, %i",
                f"  %offset = mul i64 %k, {nt}",
                "  %row = getelementptr double, ptr %table, i64 %offset",
                *body,
                "  %i1 = add i64 %i, 1",
                "  %more = icmp slt i64 %i1, %stride",
                "  br i1 %more, label %step, label %store",
                "store:",
                f"  %place = mul i64 %j, {nx * self.width}",
                "  %kept_here = getelementptr double, ptr %out, i64 %place",
                *self._stores("%x", nx, "a"),
                *self._stores("%kept_here", nx, "b"),
                "  %j1 = add i64 %j, 1",
                "  %again = icmp slt i64 %j1, %kept",
                "  br i1 %again, label %outer, label %end",
                "end:",
                "  ret void",
                "}",
            ]
        )

    def _loads(self, name: str, base: str, count: int) -> Iterator[str]:
        for i in range(count):
            yield f"  %p{name}{i} = getelementptr double, ptr {base}, i64 {i * self.width}"
            yield f"  %{name}{i} = load {self.type}, ptr %p{name}{i}, align 64"

    def _stores(self, base: str, count: int, tag: str) -> Iterator[str]:
        for i in range(count):
            yield f"  %s{tag}{i} = getelementptr double, ptr {base}, i64 {i * self.width}"
            yield f"  store {self.type} %y{i}, ptr %s{tag}{i}, align 64"

    def _body(self) -> list[str]:
        plan = self.plan
        for place in plan.inside:
            self._node(place)
        zero = self.vector(0.0)
        for i, place in enumerate(plan.graph.results):
            # x + 0 gives the result the name that the next round knows it by
            self.lines.append(f"  %y{i} = fsub {self.type} {self._value(place)}, {zero}")
        return self.lines

    def _splat(self, base: str, place: int) -> str:
        """One double from memory in every lane."""
        pointer = self.line(f"getelementptr double, ptr {base}, i64 {place}")
        number = self.line(f"load double, ptr {pointer}, align 8")
        first = self.line(f"insertelement {self.type} poison, double {number}, i64 0")
        return self.line(f"shufflevector {self.type} {first}, {self.type} poison, <{self.width} x i32> zeroinitializer")

    def _value(self, place: int) -> str:
        """The name of a value, loaded where it was made outside."""
        if place in self.values:
            return self.values[place]
        if place in self.truths:
            one, zero = self.vector(1.0), self.vector(0.0)
            return self._keep(place, f.select(self, self.truths[place], one, zero))
        node = self.plan.graph.nodes[place]
        if node.op == "const" and node.value in PLAIN:
            return self.vector(node.value)
        if place in self.plan.table:
            return self._keep(place, self._splat("%row", self.plan.table.index(place)))
        if place in self.plan.uniform:
            return self._keep(place, self._splat("%uniform", self.plan.uniform.index(place)))
        pointer = self.line(f"getelementptr double, ptr %lanes, i64 {self.plan.lanes.index(place) * self.width}")
        return self._keep(place, self.line(f"load {self.type}, ptr {pointer}, align 64"))

    def _keep(self, place: int, name: str) -> str:
        self.values[place] = name
        return name

    def _truth(self, place: int) -> str:
        """A value as a vector of truths: what is not zero is true."""
        if place not in self.truths:
            self.truths[place] = f.compare(self, "une", self._value(place), self.vector(0.0))
        return self.truths[place]

    def _node(self, place: int) -> None:
        node = self.plan.graph.nodes[place]
        op, operands = node.op, node.operands
        if op == "x":
            self.values[place] = f"%x{node.index}"
        elif op in TRUTHS:
            a, b = map(self._value, operands)
            self.truths[place] = f.compare(self, TRUTHS[op], a, b)
        elif op in ("and", "or", "not"):
            self.truths[place] = self._logic(op, operands)
        elif op in ("add", "sub"):
            self.values[place] = self._sum(op, operands)
        elif op in ("sin", "cos"):
            if operands[0] not in self.angles:
                self.angles[operands[0]] = f.reduce_angle(self, self._value(operands[0]))
            self.values[place] = f.sine_or_cosine(self, self.angles[operands[0]], int(op == "cos"))
        elif op == "mul" and self._fused(place):
            pass  # it becomes part of the sum that uses it
        else:
            self.values[place] = self._other(op, operands)

    def _logic(self, op: str, operands: tuple[int, ...]) -> str:
        flags = f.flags(self)
        if op == "not":
            ones = f"<{', '.join(['i1 true'] * self.width)}>"
            return self.line(f"xor {flags} {self._truth(operands[0])}, {ones}")
        a, b = map(self._truth, operands)
        return self.line(f"{op} {flags} {a}, {b}")

    def _fused(self, place: int) -> bool:
        """Whether a product has one use only, in a sum inside the loop: then the two round once."""
        users = self.plan.graph.users[place]
        if len(users) != 1 or place in self.plan.graph.results:
            return False
        user = self.plan.graph.nodes[users[0]]
        return user.op in ("add", "sub") and user.operands[0] != user.operands[1]

    def _product(self, place: int) -> tuple[str, str] | None:
        node = self.plan.graph.nodes[place]
        if node.op != "mul" or place not in self.inside or not self._fused(place):
            return None
        a, b = map(self._value, node.operands)
        return a, b

    def _sum(self, op: str, operands: tuple[int, ...]) -> str:
        """a + b or a - b, with a product of one use as a fused multiply and add."""
        a, b = operands
        right = self._product(b)
        if right is not None:
            x, y = right
            if op == "sub":
                x = self.line(f"fneg {self.type} {x}")
            return f.fma(self, x, y, self._plain(a))
        left = self._product(a)
        if left is not None:
            c = self._value(b)
            if op == "sub":
                c = self.line(f"fneg {self.type} {c}")
            return f.fma(self, *left, c)
        return f.binary(self, BINARY[op], self._value(a), self._value(b))

    def _plain(self, place: int) -> str:
        """A value, also of a product that could have been fused but was not."""
        product = self._product(place)
        return self._value(place) if product is None else f.binary(self, "fmul", *product)

    def _other(self, op: str, operands: tuple[int, ...]) -> str:
        if op == "if_else_zero":
            return f.select(self, self._truth(operands[0]), self._value(operands[1]), self.vector(0.0))
        values = [self._value(i) for i in operands]
        if op in BINARY:
            return f.binary(self, BINARY[op], *values)
        if op in UNARY:
            return f.unary(self, UNARY[op], *values)
        if op in COMPOSED:
            return COMPOSED[op](self, *values)
        match op:
            case "neg":
                return self.line(f"fneg {self.type} {values[0]}")
            case "inv":
                return f.binary(self, "fdiv", self.vector(1.0), values[0])
            case "fmin" | "fmax":
                return f.select(self, f.compare(self, "olt" if op == "fmin" else "ogt", *values), *values)
            case "sign":
                return self._sign(values[0])
            case "fmod":
                turns = f.unary(self, "trunc", f.binary(self, "fdiv", *values))
                return f.fma(self, self.line(f"fneg {self.type} {turns}"), values[1], values[0])
        raise ValueError(f"The operation '{op}' has no lowering inside the time loop of the batch engine.")

    def _sign(self, x: str) -> str:
        zero = self.vector(0.0)
        below = f.select(self, f.compare(self, "olt", x, zero), self.vector(-1.0), x)
        return f.select(self, f.compare(self, "ogt", x, zero), self.vector(1.0), below)
