r"""LaTeX to tokens: `m_{2} l_{1} \dot{q}_1 \sin^2 q_2`, matrices, displays; any macro unknown here is refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from workbench.notation.formula import ACCENTS as OVER_LETTERS
from workbench.notation.formula import GREEK
from workbench.printed.tokens import DEEPEST, FUNCTIONS, Token, checked, cut, refusal, refuse_size


def _words(listed: str) -> frozenset[str]:
    return frozenset(listed.split())


MATRICES = _words("matrix bmatrix pmatrix Bmatrix smallmatrix array")
DISPLAYS = _words(
    "equation align aligned alignat gather gathered split multline eqnarray flalign displaymath math document"
)
# Macros that only move signs on the page, or make brackets larger.
SPACES = _words(
    ", ; : ! > quad qquad enspace thinspace displaystyle textstyle nonumber notag limits noindent relax "
    "allowdisplaybreaks big Big bigg Bigg bigl bigr Bigl Bigr biggl biggr Biggl Biggr"
) | {" ", "\n"}
STYLES = _words("mathbf boldsymbol bm mathrm mathit mathsf mathcal text texttt textrm mathtt operatorname vec")
DOTS = {"dot": 1, "ddot": 2}
ACCENTS = frozenset(OVER_LETTERS)
GREEK_LETTERS = {name: name for name in GREEK} | {f"var{name}": name for name in ("epsilon", "phi", "theta", "rho")}
UPRIGHT = _words("operatorname mathrm text textrm")  # in which functions are written that have no macro
BRACKETS = {"{": "(", "}": ")", "lbrack": "[", "rbrack": "]", "lbrace": "(", "rbrace": ")"}
TIMES = _words("cdot times ast")
FRACTIONS = _words("frac dfrac tfrac cfrac")

_SPACE = re.compile(r"[ \t\r\f\n~]+|(?<!\\)%[^\n]*|\{\s*\}")
_COMMAND = re.compile(r"\\([A-Za-z]+|.|\n)", re.DOTALL)
_ENVIRONMENT = re.compile(r"\\(begin|end)\s*\{([A-Za-z]+)\*?\}")
_COLUMNS = re.compile(r"\s*(\[[tbc]\])?\s*\{[lcr| @{}]*\}")
_PATH = re.compile(r"[A-Za-z]+(\[[0-9]+\])*(\.[A-Za-z]\w*(\[[0-9]+\])*)+")
_NUMBER = re.compile(r"[0-9]+(\.[0-9]+)?|\.[0-9]+")
_ROW = re.compile(r"\\\\\*?(\s*\[-?[0-9.]+\s*(pt|mm|cm|em|ex)\])?|\\cr\b")
_NAMED = re.compile(r"\\(label|tag|vspace|hspace)\*?\s*\{[^{}\\]*\}")
_TRANSPOSE = re.compile(
    r"\^\s*(T\b|\{\s*T\s*\}|\\top\b|\{\s*\\(top|intercal)\s*\}|\\intercal\b|\{\s*\\mathrm\s*\{?\s*T\s*\}?\s*\})"
)
_EARLY_POWER = re.compile(r"\^\s*(\{\s*([0-9]+)\s*\}|([0-9]))\s*(?=_)")
_INDEX = re.compile(r"\s*_\s*")
# What an index may hold beside letters and digits: styles, thin spaces, braces; of a Greek letter the backslash.
_BELOW = re.compile(
    rf"\\({'|'.join([*STYLES, 'rm'])})(?![A-Za-z])|\\[,;!]|[{{}}_\s]|\\(?=({'|'.join(GREEK_LETTERS)})(?![A-Za-z]))"
)
# A letter, perhaps dotted or in a style, in braces of its own before its index, as {m}_2 and {\dot{q}}_{1}.
_BRACED = re.compile(
    r"\{(\s{0,3}(?:[A-Za-z]|(?:\\[A-Za-z]+\s{0,3}){1,3}(?:[A-Za-z]|\{\s{0,3}[A-Za-z]\s{0,3}\})?)\s{0,3})\}(?=\s{0,3}_)"
)
# Behind these, braces hold an argument.
_TAKES = re.compile(
    rf"([_^]|\\({'|'.join(sorted([*STYLES, *DOTS, *ACCENTS, *FRACTIONS, 'sqrt']))})"
    rf"|\\({'|'.join(sorted(FRACTIONS))})\s*\{{[^{{}}]*\}})\s*$"
)
_MANY = re.compile(rf"(?:\\[A-Za-z]+[\s{{]*){{{DEEPEST}}}")

READ = r"formulas are made of symbols, numbers, \frac, \sqrt, \sin, \cos, \tan, \dot, \left, \right and matrices"


@dataclass(frozen=True)
class _Symbol:
    """A symbol in the making; a power may be written before the index."""

    letters: str
    index: str = ""
    dots: int = 0
    power: str = ""


def tokens_of_latex(text: str) -> tuple[Token, ...]:
    """The tokens of LaTeX source; displays, blank lines, and rows outside of a matrix are "break"s."""
    refuse_size(text)
    if many := _MANY.search(text):
        raise refusal(
            _Source(text).place(many.start()), f"{DEEPEST} macros stand here one on the other; write what they mean."
        )

    def without_braces(found: re.Match[str]) -> str:  # blanks for braces, so that every place stays what it was
        before = text[max(found.start() - 60, 0) : found.start()]
        return found.group() if _TAKES.search(before) else f" {found[1]} "

    return checked(_Source(_BRACED.sub(without_braces, text)).scan())


@dataclass(frozen=True)
class _Source:
    """The text, read from a place on."""

    text: str

    def place(self, at: int) -> tuple[int, int]:
        """Line and column of a character."""
        return self.text.count("\n", 0, at) + 1, at - self.text.rfind("\n", 0, at)

    def scan(self) -> Iterator[Token]:
        at, matrices = 0, 0
        while at < len(self.text):
            if space := _SPACE.match(self.text, at):
                if re.search(r"\n[ \t\r]*\n", self.text[at : space.end()]) and not matrices:
                    yield self.token("break", "a blank line", at)
                at = space.end()
            elif found := _ENVIRONMENT.match(self.text, at):
                at, token = self.environment(found)
                matrices += {"begin": 1, "end": -1}.get(token.kind, 0)
                yield token
            elif found := _ROW.match(self.text, at):
                yield self.token("row" if matrices else "break", r"\\", at)
                at = found.end()
            elif found := _TRANSPOSE.match(self.text, at):
                yield self.token("transpose", found.group(), at)
                at = found.end()
            else:
                found_tokens, at = self.piece(at)
                yield from found_tokens

    def token(self, kind: str, said: str, at: int) -> Token:
        """A token that begins at a character."""
        return Token(kind, said, *self.place(at))

    def environment(self, found: re.Match[str]) -> tuple[int, Token]:
        """The begin or end of a matrix, or that of a display, which is a break."""
        what, name = found.groups()
        if name in MATRICES:
            at = found.end()
            if name == "array" and what == "begin":
                columns = _COLUMNS.match(self.text, at)
                at = columns.end() if columns else at
            return at, self.token(what, found.group(), found.start())
        if name not in DISPLAYS:
            known = ", ".join(sorted(MATRICES | {"equation", "align", "aligned"}))
            raise refusal(
                self.place(found.start()), f"the environment '{cut(name)}' is not read here; known are {known}."
            )
        argument = re.match(r"\s*\{[0-9]+\}", self.text[found.end() :]) if name == "alignat" else None
        return found.end() + (argument.end() if argument else 0), self.token("break", found.group(), found.start())

    def piece(self, at: int) -> tuple[tuple[Token, ...], int]:
        """The token, or those of a symbol, at a character that is no space."""
        character = self.text[at]
        if path := _PATH.match(self.text, at):
            return (self.token("name", path.group(), at),), path.end()
        if number := _NUMBER.match(self.text, at):
            return (self.token("number", number.group(), at),), number.end()
        if character == "$":
            end = at + 1 + (self.text[at : at + 2] == "$$")
            return (self.token("break", self.text[at:end], at),), end
        if character == "\\" and (plain := self.command(at)) is not None:
            return plain
        if character == "\\" or character.isalpha():
            symbol, end = self.symbol(at)
            name = Token("name", symbol.letters, *self.place(at), symbol.index, symbol.dots)
            power = (self.token("^", "^", at), self.token("number", symbol.power, at)) if symbol.power else ()
            return (name, *power), end
        if character in "+-*/^()[]{},;=.'&":
            return self.sign(character, at)
        raise refusal(self.place(at), f"{character!r} is no sign of a formula in LaTeX.")

    def sign(self, character: str, at: int) -> tuple[tuple[Token, ...], int]:
        """A sign; a power of several digits without braces prints another formula than it seems."""
        if character == "^" and (digits := re.match(r"\^\s*([0-9]{2,})", self.text[at:])):
            first, rest = digits[1][0], digits[1][1:]
            raise refusal(
                self.place(at),
                f"'^{cut(digits[1])}' prints {first} above and {cut(rest)} behind it; write '^{{{cut(digits[1])}}}'.",
            )
        return (self.token(character, character, at),), at + 1

    def command(self, at: int) -> tuple[tuple[Token, ...], int] | None:
        """The tokens that a macro means, or None where it begins a symbol."""
        if named := _NAMED.match(self.text, at):
            return (), named.end()
        found = _COMMAND.match(self.text, at)
        if found is None:
            raise refusal(self.place(at), "the text ends with a backslash.")
        name, end = found[1], found.end()
        if name == "left" or name == "right":
            empty = re.match(r"\s*\.", self.text[end:])
            return (), end + (empty.end() if empty else 0)
        if name in SPACES:
            return (), end
        if name in "[]()":
            return (self.token("break", f"\\{name}", at),), end
        if name in BRACKETS:
            return (self.token(BRACKETS[name], f"\\{name}", at),), end
        if name in TIMES:
            return (self.token("*", f"\\{name}", at),), end
        if name in FRACTIONS:
            bare = re.match(r"\s*([0-9])\s*([0-9])", self.text[end:])  # \frac12
            parts = tuple(self.token("number", digit, end) for digit in bare.groups()) if bare else ()
            return (self.token("frac", f"\\{name}", at), *parts), end + (bare.end() if bare else 0)
        if name in FUNCTIONS:
            return (self.token("function", name, at),), end
        styled = re.match(r"\s*\{\s*(\w+)\s*\}", self.text[end:]) if name in UPRIGHT else None
        if styled and styled[1] in FUNCTIONS:
            return (self.token("function", styled[1], at),), end + styled.end()
        if (
            name in STYLES
            and (path := re.match(r"\s*\{\s*([^{}]*)\s*\}", self.text[end:]))
            and _PATH.fullmatch(path[1])
        ):
            return (self.token("name", path[1], at),), end + path.end()
        return None

    def symbol(self, at: int) -> tuple[_Symbol, int]:
        """The letters that begin at a character, with the signs over and below them."""
        symbol, at = self.letters(at)
        while True:
            if (early := _EARLY_POWER.match(self.text, at)) and not symbol.power:
                symbol, at = replace(symbol, power=early[2] or early[3]), early.end()
            elif (index := _INDEX.match(self.text, at)) and index.group().strip():
                below, at = self.index(index.end())
                symbol = replace(symbol, index=",".join(filter(None, [symbol.index, below])))
            else:
                return symbol, at

    def letters(self, at: int) -> tuple[_Symbol, int]:
        """Letters, a Greek one, or one in a style or under dots."""
        if run := re.match(r"[A-Za-z]+", self.text[at:]):
            return _Symbol(run.group()), at + run.end()
        found = _COMMAND.match(self.text, at)
        name, end = (found[1], found.end()) if found else ("", at)
        if name == "ell":
            return _Symbol("l"), end
        if name == "pi" or name in GREEK_LETTERS:
            return _Symbol(GREEK_LETTERS.get(name, name)), end
        if name in STYLES or name in DOTS or name in ACCENTS:
            symbol, end = self.argument(end)
            if name in ACCENTS:
                return replace(symbol, letters=f"{symbol.letters}_{name}"), end
            return replace(symbol, dots=symbol.dots + DOTS.get(name, 0)), end
        unknown = re.match(r"\\?[A-Za-z]+[0-9]*", self.text[at:])  # with the number behind it, as in \write18
        macro = cut(unknown.group()) if unknown else self.text[at : at + 2]
        raise refusal(self.place(at), f"'{macro}' is not read here: {READ}; no macro is run, no file is read.")

    def argument(self, at: int) -> tuple[_Symbol, int]:
        """The symbol to which a macro is applied: one letter, one macro, or the content of braces."""
        at += len(self.text[at:]) - len(self.text[at:].lstrip())
        if at < len(self.text) and self.text[at].isalpha():
            return _Symbol(self.text[at]), at + 1
        if self.text[at : at + 1] != "{":
            return self.letters(at)
        symbol, end = self.symbol(at + 1 + len(self.text[at + 1 :]) - len(self.text[at + 1 :].lstrip()))
        digits = re.match(r"([0-9]*)\s*\}", self.text[end:])
        if digits is None:
            raise refusal(self.place(at), "dots and styles stand over one symbol here; write it as \\dot{q}_1.")
        return replace(symbol, index=symbol.index + digits[1]), end + digits.end()

    def index(self, at: int) -> tuple[str, int]:
        """The index below a symbol, without its braces."""
        if self.text[at : at + 1] != "{":
            if several := re.match(r"[0-9]{2,}", self.text[at:]):
                said = cut(several[0])
                raise refusal(self.place(at), f"'_{said}' prints only its first digit below; write '_{{{said}}}'.")
            if not re.match(r"[A-Za-z0-9]", self.text[at:]):
                symbol, end = self.letters(at)
                return symbol.letters, end
            return self.text[at], at + 1
        depth, end = 0, at
        while end < len(self.text):
            depth += {"{": 1, "}": -1}.get(self.text[end], 0)
            end += 1
            if depth == 0:
                break
        inner = _BELOW.sub(" ", self.text[at:end])
        if unknown := re.search(r"\\[A-Za-z]+", inner):
            raise refusal(self.place(at), f"'{cut(unknown.group())}' is not read here: {READ}; no macro is run.")
        inner = inner.replace(" ", "")
        if depth or not re.fullmatch(r"[A-Za-z0-9,*]*", inner):
            raise refusal(self.place(at), f"an index is made of letters and digits; got '{cut(self.text[at:end])}'.")
        return inner, end
