"""The parser of tokens to a formula: sums, products written or implied, powers, functions, fractions and matrices.

    expression = [sign] product {sign product}
    product    = power {("*" | "/" | nothing) power}
    power      = atom [("^" exponent) | transpose | "'"]
    atom       = number | name | function argument | "(" expression ")" | "[" rows "]" | matrix | fraction

Nothing is evaluated here, and no name is looked up anywhere but among those that are given.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction

from workbench.arms.paper_equations.formula_values import HIGHEST_POWER, check_depth
from workbench.arms.paper_equations.tokens import (
    BRACKETS,
    DEEPEST,
    FUNCTIONS,
    PI,
    FormulaError,
    Names,
    Token,
    exact_number,
    refusal,
)
from workbench.core.notation import build
from workbench.core.notation.formula import Formula, Matrix, Number, Symbol

STARTS = {"number", "name", "function", "frac", "begin", *"([{"}
MINUS_ONE = Number(Fraction(-1))


def parse(tokens: Sequence[Token], names: Names) -> Formula:
    """The formula that all the tokens make, with the symbols of `names`; a `FormulaError` says where they make none."""
    if not tokens:
        raise ValueError("`parse(tokens)` takes at least one token; got none.")
    reader = _Reader(tokens, names)
    try:
        formula = reader.expression()
        if reader.kind:
            raise reader.refusal_of_next()
    except FormulaError:
        raise
    except ValueError as error:
        raise refusal(reader.tokens[max(reader.at - 1, 0)], str(error)) from None
    return check_depth(formula, tokens[0])


class _Reader:
    """A reader of tokens at a place, which each rule moves behind the tokens that it has read."""

    def __init__(self, tokens: Sequence[Token], names: Names) -> None:
        self.tokens = tokens
        self.names = names
        self.at = 0
        self.level = 0

    @contextmanager
    def within(self, token: Token) -> Iterator[None]:
        """Read the tokens that belong to one, as brackets to a function, with a limit on the nesting."""
        self.level += 1
        if self.level > 2 * DEEPEST:
            raise refusal(token, f"more than {2 * DEEPEST} parts are nested in each other; write the formula in parts.")
        yield
        self.level -= 1

    @property
    def kind(self) -> str:
        return self.tokens[self.at].kind if self.at < len(self.tokens) else ""

    def take(self) -> Token:
        if self.at == len(self.tokens):
            raise refusal(self.tokens[-1], f"the formula breaks off after '{self.tokens[-1].quotation}'.")
        self.at += 1
        return self.tokens[self.at - 1]

    def refusal_of_next(self) -> FormulaError:
        token = self.take()
        advice = ", and the sign of decimals is '.'" if token.kind == "," else ""
        return refusal(
            token, f"'{token.quotation}' cannot stand here; a number, a name or an opening bracket can{advice}."
        )

    def expression(self) -> Formula:
        terms: list[Formula] = []
        while True:
            minus = self.signs(is_required=bool(terms))
            term = self.product()
            terms.append(_product([MINUS_ONE, term]) if minus else term)
            if self.kind not in ("+", "-"):
                return _total(terms)

    def signs(self, *, is_required: bool) -> bool:
        """True if the signs before a term, of which there may be two as in a + -b, make it negative."""
        minus = False
        if is_required or self.kind in ("+", "-"):
            minus = self.take().kind == "-"
        if self.kind in ("+", "-"):
            minus ^= self.take().kind == "-"
        return minus

    def product(self) -> Formula:
        """Factors with or without a sign between them; a division that may be read in two ways is refused."""
        factors = self.power()
        unclear: Token | None = None
        while True:
            if self.kind == "*":
                self.take()
                factors, unclear = factors + self.power(is_signed=True), None
            elif self.kind == "/":
                slash = self.take()
                divisor = _product(self.power(is_signed=True))
                both = isinstance(factors[-1], Number) and isinstance(divisor, Number)
                factors, unclear = [*factors, self.inverse(divisor, slash)], None if both else slash
            elif self.kind in STARTS:
                if unclear:
                    advice = "Behind 'a/b' write '*' or brackets: '(a/b)*c' or 'a/(b*c)'."
                    raise refusal(unclear, f"what is divided by? {advice}")
                factors += self.power()
            else:
                return _product(factors)

    def inverse(self, divisor: Formula, sign: Token) -> Formula:
        if isinstance(divisor, Matrix) or divisor == build.ZERO:
            raise refusal(sign, "a matrix is no divisor." if isinstance(divisor, Matrix) else "this divides by zero.")
        return build.quotient(build.ONE, divisor)

    def power(self, *, is_signed: bool = False) -> list[Formula]:
        if is_signed and self.kind in ("+", "-"):
            minus = self.take().kind == "-"
            return [MINUS_ONE, *self.power()] if minus else self.power()
        factors = self.atom()
        while self.kind in ("^", "transpose", "'"):
            token = self.take()
            if token.kind == "^":
                factors[-1] = self.with_power(factors[-1], token)
            elif isinstance(factors[-1], Matrix):
                factors[-1] = Matrix(tuple(zip(*factors[-1].rows, strict=True)))
            elif token.kind == "'" and isinstance(factors[-1], Symbol):
                factors[-1] = self.rate(factors[-1], token)
            else:
                raise refusal(token, "only a matrix is transposed, and only a symbol has a rate.")
        return factors

    def with_power(self, base: Formula, sign: Token) -> Formula:
        with self.within(sign):
            exponent = _product(self.power(is_signed=True))
        if isinstance(base, Matrix):
            raise refusal(sign, "a matrix has no power here; write its entries.")
        must = f"an exponent is a whole number or a half, of size at most {HIGHEST_POWER}"
        if not isinstance(exponent, Number) or isinstance(exponent.value, float):
            raise refusal(sign, f"{must}; got a formula.")
        if abs(exponent.value) > HIGHEST_POWER or exponent.value.denominator > 2:
            raise refusal(sign, f"{must}.")
        if base == build.ZERO and exponent.value <= 0:
            raise refusal(sign, "zero has no such power.")
        return build.power(base, exponent)

    def rate(self, base: Symbol, prime: Token) -> Symbol:
        """The symbol of a derivative in time, q_1' for q dot 1, found by the spelling before the prime."""
        said = self.tokens[self.at - 2]
        if said.kind == "name" and self.names.find(said.text, said.index, said.dots) == base:
            found = self.names.find(said.text, said.index, said.dots + 1)
        else:
            found = self.names.find(base.letter, base.index, base.dots + 1)
            found = found if found is None or found.bold == base.bold else None  # another's, that is spelled alike
        if found is None:
            raise refusal(prime, f"the rate of '{base.letter}' is no name of this robot.")
        return found

    def atom(self) -> list[Formula]:
        token = self.take()
        with self.within(token):
            match token.kind:
                case "number":
                    return [Number(exact_number(token))]
                case "name":
                    if token.text == "pi" and not token.index and self.names.find("pi") is None:
                        return [PI]
                    return list(self.names.split(token))
                case "function":
                    return [self.call(token)]
                case "frac":
                    above, below = self.argument(), self.argument()
                    return [_product([above, self.inverse(below, token)])]
                case "(" | "{":
                    inner = self.expression()
                    self.close(token)
                    return [inner]
                case "[" | "begin":
                    return [self.matrix(token)]
        self.at -= 1
        raise self.refusal_of_next()

    def close(self, opening_bracket: Token) -> None:
        if self.kind != BRACKETS[opening_bracket.kind]:
            raise self.refusal_of_next()
        self.take()

    def argument(self) -> Formula:
        if self.kind == "number" and len(self.tokens[self.at].text) > 1:
            raise refusal(self.tokens[self.at], r"write the parts of \frac in braces.")
        return _product(self.atom())

    def call(self, token: Token) -> Formula:
        """A function of the brackets behind it, or of one factor: sin^2 q_2, sin 2 q_2, sqrt(2)."""
        exponent = None
        if self.kind == "^" and token.text in FUNCTIONS:
            sign = self.take()
            exponent = _product(self.power(is_signed=True) if self.kind != "{" else self.atom())
            if not isinstance(exponent, Number) or not 0 < exponent.value <= HIGHEST_POWER:
                must = f"is followed by a whole number from 1 to {HIGHEST_POWER}, as in sin^2 q_1."
                raise refusal(sign, f"'{token.text}^' {must}")
        inner = self.plain_argument(token)
        if isinstance(inner, Matrix):
            raise refusal(token, f"'{token.text}' takes a number, no matrix.")
        called = build.call(token.text, inner)
        return called if exponent is None else build.power(called, exponent)

    def plain_argument(self, function: Token) -> Formula:
        """The argument of a function: a bracket, or one factor with a number before it if there is one."""
        if self.kind not in STARTS or self.kind == "function":
            raise refusal(function, f"write what '{function.text}' is taken of, as in {function.text}(q_1).")
        if self.kind in ("(", "[", "{"):
            return _product(self.atom())
        if self.kind == "number" and self.at + 1 < len(self.tokens) and self.tokens[self.at + 1].kind == "name":
            return _product([*self.atom(), *self.one_name(function)])
        return _product(self.one_name(function)) if self.kind == "name" else _product(self.power())

    def one_name(self, function: Token) -> list[Formula]:
        factors = self.atom()
        if len(factors) > 1 or self.kind == "^":
            raise refusal(function, f"where does '{function.text}' end? Write brackets: {function.text}(...).")
        return factors

    def matrix(self, opening_bracket: Token) -> Formula:
        """Rows of entries; a lone entry is the entry itself, and a list of lists its rows."""
        rows: list[list[Formula]] = [[]]
        closing = BRACKETS[opening_bracket.kind]
        between, below = ((",",), (";",)) if opening_bracket.kind == "[" else (("&",), ("row",))
        while True:
            while opening_bracket.kind == "begin" and self.kind == "row":  # an empty row, as before \end
                self.take()
            if self.kind == closing and rows[-1] == [] and len(rows) > 1:
                rows.pop()
                break
            rows[-1].append(self.expression())
            if self.kind in between:
                self.take()
            elif self.kind in below:
                self.take()
                rows.append([])
            elif self.kind == closing:
                break
            else:
                raise self.refusal_of_next()
        self.close(opening_bracket)
        return _matrix(rows, opening_bracket)


def _matrix(rows: list[list[Formula]], opening_bracket: Token) -> Formula:
    """The matrix of these rows; a lone entry is itself, and a row of matrices is stacked."""
    if len(rows) == 1 and len(rows[0]) == 1:
        return rows[0][0]
    if len(rows) == 1 and any(isinstance(entry, Matrix) and len(entry.rows) == 1 for entry in rows[0]):
        rows = [list(entry.rows[0]) if isinstance(entry, Matrix) else [entry] for entry in rows[0]]
    if len({len(row) for row in rows}) > 1:
        lengths = ", ".join(str(len(row)) for row in rows)
        raise refusal(opening_bracket, f"the rows of a matrix are equally long; these have {lengths}.")
    if any(isinstance(entry, Matrix) for row in rows for entry in row):
        raise refusal(opening_bracket, "an entry of a matrix is a number, no matrix.")
    return Matrix(tuple(map(tuple, rows)))


def _product(factors: list[Formula]) -> Formula:
    matrices = [factor for factor in factors if isinstance(factor, Matrix)]
    if not matrices:
        return build.product(factors) if len(factors) > 1 else factors[0]
    if len(matrices) > 1:
        raise ValueError("a product of two matrices is not read; write its entries.")
    scale = [factor for factor in factors if not isinstance(factor, Matrix)]
    return Matrix(tuple(tuple(build.product([*scale, entry]) for entry in row) for row in matrices[0].rows))


def _total(terms: list[Formula]) -> Formula:
    matrices = [term for term in terms if isinstance(term, Matrix)]
    if not matrices:
        return build.total(terms)
    shapes = {(len(term.rows), len(term.rows[0])) for term in matrices}
    if len(matrices) < len(terms) or len(shapes) > 1:
        raise ValueError("only matrices of one shape are added; write the entries of the sum.")
    added = (zip(*rows, strict=True) for rows in zip(*(matrix.rows for matrix in matrices), strict=True))
    return Matrix(tuple(tuple(map(build.total, row)) for row in added))
