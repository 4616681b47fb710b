r"""LaTeX to tokens: `m_{2} l_{1} \dot{q}_1 \sin^2 q_2`, matrices, displays; any macro unknown here is refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from workbench.arms.paper_equations.tokens import (
    DEEPEST,
    FUNCTIONS,
    Token,
    checked_tokens,
    refusal,
    refuse_size,
    shorten,
)
from workbench.core.notation.formula import ACCENTS, GREEK


def _words(words: str) -> list[str]:
    return words.split()


MATRICES = _words("matrix bmatrix pmatrix Bmatrix smallmatrix array")
DISPLAYS = _words(
    "equation align aligned alignat gather gathered split multline eqnarray flalign displaymath math document"
)
# Macros that only move signs on the page, or make brackets larger.
SPACES = _words(
    ", ; : ! > quad qquad enspace thinspace displaystyle textstyle nonumber notag limits noindent relax "
    "allowdisplaybreaks big Big bigg Bigg bigl bigr Bigl Bigr biggl biggr Biggl Biggr"
)
FRACTIONS = _words("frac dfrac tfrac cfrac")
# The kind of token for which a macro stands; empty for none.
KINDS = {"{": "(", "}": ")", "lbrack": "[", "rbrack": "]", "lbrace": "(", "rbrace": ")"}
KINDS |= dict.fromkeys([*SPACES, " ", "\n"], "") | dict.fromkeys("[]()", "break") | dict.fromkeys(FUNCTIONS, "function")
KINDS |= dict.fromkeys(["cdot", "times", "ast"], "*") | dict.fromkeys(FRACTIONS, "frac")
UPRIGHT = _words("operatorname mathrm text textrm")  # in which functions are written that have no macro
STYLES = [*_words("mathbf boldsymbol bm mathit mathsf mathcal texttt mathtt vec"), *UPRIGHT]
DOTS = {"dot": 1, "ddot": 2}
GREEK_LETTERS = {name: name for name in GREEK} | {f"var{name}": name for name in ("epsilon", "phi", "theta", "rho")}
LETTERS = GREEK_LETTERS | {"ell": "l"}

_SPACE = re.compile(r"[ \t\r\f\n~]+|(?<!\\)%[^\n]*|\{\s*\}")
_COMMAND = re.compile(r"\\([A-Za-z]+|.|\n)", re.DOTALL)
_ENVIRONMENT = re.compile(r"\\(begin|end)\s*\{([A-Za-z]+)\*?\}")
_COLUMNS = re.compile(r"\s*(\[[tbc]\])?\s*\{[lcr| @{}]*\}")
_PATH = re.compile(r"[A-Za-z]+(\[[0-9]+\])*(\.[A-Za-z]\w*(\[[0-9]+\])*)+")
_NUMBER = re.compile(r"[0-9]+(\.[0-9]+)?|\.[0-9]+")
_ROW = re.compile(r"\\\\\*?(\s*\[-?[0-9.]+\s*(pt|mm|cm|em|ex)\])?|\\cr\b")
_NAMED_COMMANDS = re.compile(r"\\(label|tag|vspace|hspace)\*?\s*\{[^{}\\]*\}")
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
_BRACED_LETTER = re.compile(
    r"\{(\s{0,3}(?:[A-Za-z]|(?:\\[A-Za-z]+\s{0,3}){1,3}(?:[A-Za-z]|\{\s{0,3}[A-Za-z]\s{0,3}\})?)\s{0,3})\}(?=\s{0,3}_)"
)
# Behind these, braces hold an argument.
_TAKES = re.compile(
    rf"([_^]|\\({'|'.join(sorted([*STYLES, *DOTS, *ACCENTS, *FRACTIONS, 'sqrt']))})"
    rf"|\\({'|'.join(sorted(FRACTIONS))})\s*\{{[^{{}}]*\}})\s*$"
)
_BLANK, _RUN, _MANY_DIGITS = re.compile(r"\s*"), re.compile(r"[A-Za-z]+"), re.compile(r"\s*([0-9]{2,})")
_NO_FENCE, _COUNT = re.compile(r"\s*\."), re.compile(r"\s*\{[0-9]+\}")
_TWO_DIGITS = re.compile(r"\s*([0-9])\s*([0-9])")
_BRACES = re.compile(r"\s*\{\s*([^{}]*?)\s*\}")
_UNKNOWN_WORD = re.compile(r"\\?[A-Za-z]+[0-9]*")  # with the number behind it, as in \write18
_REST = re.compile(r"([0-9]*)\s*\}")
_MANY = re.compile(rf"(?:\\[A-Za-z]+[\s{{]*){{{DEEPEST}}}")

GRAMMAR_TEXT = (
    r"formulas are made of symbols, numbers, \frac, \sqrt, \sin, \cos, \tan, \dot, \left, \right and matrices"
)


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
        place = _Source(text).place(many.start())
        raise refusal(place, f"{DEEPEST} macros stand here one on the other; write what they mean.")

    def without_braces(match: re.Match[str]) -> str:  # blanks for braces, so that every place stays what it was
        before = text[max(match.start() - 60, 0) : match.start()]
        return match.group() if _TAKES.search(before) else f" {match[1]} "

    return checked_tokens(_Source(_BRACED_LETTER.sub(without_braces, text)).scan())


@dataclass(frozen=True)
class _Source:
    """The text, read from a place on."""

    text: str

    def place(self, at: int) -> tuple[int, int]:
        return self.text.count("\n", 0, at) + 1, at - self.text.rfind("\n", 0, at)

    def token(self, kind: str, message: str, at: int) -> Token:
        return Token(kind, message, *self.place(at))

    def behind(self, pattern: re.Pattern[str], at: int) -> int:
        """The place behind a pattern, or the same place where it does not stand."""
        found = pattern.match(self.text, at)
        return found.end() if found else at

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

    def environment(self, match: re.Match[str]) -> tuple[int, Token]:
        what, name = match.groups()
        if name in MATRICES:
            columns = name == "array" and what == "begin"
            end = self.behind(_COLUMNS, match.end()) if columns else match.end()
            return end, self.token(what, match.group(), match.start())
        if name not in DISPLAYS:
            known = ", ".join(sorted([*MATRICES, "equation", "align", "aligned"]))
            place = self.place(match.start())
            raise refusal(place, f"the environment '{shorten(name)}' is not read here; known are {known}.")
        end = self.behind(_COUNT, match.end()) if name == "alignat" else match.end()
        return end, self.token("break", match.group(), match.start())

    def piece(self, at: int) -> tuple[tuple[Token, ...], int]:
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
        if character == "^" and (digits := _MANY_DIGITS.match(self.text, at + 1)):
            first, rest, both = digits[1][0], shorten(digits[1][1:]), shorten(digits[1])
            raise refusal(self.place(at), f"'^{both}' prints {first} above and {rest} behind it; write '^{{{both}}}'.")
        return (self.token(character, character, at),), at + 1

    def command(self, at: int) -> tuple[tuple[Token, ...], int] | None:
        """The tokens that a macro means, or None where it begins a symbol."""
        if named := _NAMED_COMMANDS.match(self.text, at):
            return (), named.end()
        found = _COMMAND.match(self.text, at)
        if found is None:
            raise refusal(self.place(at), "the text ends with a backslash.")
        name, end = found[1], found.end()
        if name in ("left", "right"):
            return (), self.behind(_NO_FENCE, end)
        if (kind := KINDS.get(name)) is not None:
            tokens = (self.token(kind, name if kind == "function" else f"\\{name}", at),) if kind else ()
            if kind == "frac" and (bare := _TWO_DIGITS.match(self.text, end)):  # \frac12
                return (*tokens, *(self.token("number", digit, end) for digit in bare.groups())), bare.end()
            return tokens, end
        if name in STYLES and (braced := _BRACES.match(self.text, end)):
            if name in UPRIGHT and braced[1] in FUNCTIONS:
                return (self.token("function", braced[1], at),), braced.end()
            if _PATH.fullmatch(braced[1]):
                return (self.token("name", braced[1], at),), braced.end()
        return None

    def symbol(self, at: int) -> tuple[_Symbol, int]:
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
        if run := _RUN.match(self.text, at):
            return _Symbol(run.group()), run.end()
        found = _COMMAND.match(self.text, at)
        name, end = (found[1], found.end()) if found else ("", at)
        if name in LETTERS:
            return _Symbol(LETTERS[name]), end
        if name in STYLES or name in DOTS or name in ACCENTS:
            symbol, end = self.argument(end)
            accented = f"{symbol.letters}_{name}" if name in ACCENTS else symbol.letters
            return replace(symbol, letters=accented, dots=symbol.dots + DOTS.get(name, 0)), end
        unknown = _UNKNOWN_WORD.match(self.text, at)
        macro = shorten(unknown.group()) if unknown else self.text[at : at + 2]
        raise refusal(self.place(at), f"'{macro}' is not read here: {GRAMMAR_TEXT}; no macro is run, no file is read.")

    def argument(self, at: int) -> tuple[_Symbol, int]:
        """The symbol to which a macro is applied: one letter, one macro, or the content of braces."""
        at = self.behind(_BLANK, at)
        if at < len(self.text) and self.text[at].isalpha():
            return _Symbol(self.text[at]), at + 1
        if self.text[at : at + 1] != "{":
            return self.letters(at)
        symbol, end = self.symbol(self.behind(_BLANK, at + 1))
        digits = _REST.match(self.text, end)
        if digits is None:
            raise refusal(self.place(at), "dots and styles stand over one symbol here; write it as \\dot{q}_1.")
        return replace(symbol, index=symbol.index + digits[1]), digits.end()

    def index(self, at: int) -> tuple[str, int]:
        if self.text[at : at + 1] != "{":
            if several := _MANY_DIGITS.match(self.text, at):
                said = shorten(several[1])
                raise refusal(self.place(at), f"'_{said}' prints only its first digit below; write '_{{{said}}}'.")
            if re.match(r"[A-Za-z0-9]", self.text[at : at + 1]):
                return self.text[at], at + 1
            symbol, end = self.letters(at)
            return symbol.letters, end
        depth, end = 0, at
        while end < len(self.text):
            depth += {"{": 1, "}": -1}.get(self.text[end], 0)
            end += 1
            if depth == 0:
                break
        inner = _BELOW.sub(" ", self.text[at:end])
        if unknown := re.search(r"\\[A-Za-z]+", inner):
            raise refusal(
                self.place(at), f"'{shorten(unknown.group())}' is not read here: {GRAMMAR_TEXT}; no macro is run."
            )
        inner = inner.replace(" ", "")
        if depth or not re.fullmatch(r"[A-Za-z0-9,*]*", inner):
            raise refusal(
                self.place(at), f"an index is made of letters and digits; got '{shorten(self.text[at:end])}'."
            )
        return inner, end
