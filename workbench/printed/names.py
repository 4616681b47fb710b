"""The names a formula may use, however they are written: `l_c1`, `lc1`, `l_{c1}` and `l_{c,1}` are one."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from workbench.notation.formula import Symbol, name_of, symbol
from workbench.printed.tokens import Token, cut, refusal

# Letters with their index, without what sets the two apart; dots; accent and mark.
Key = tuple[str, int, str]
PI = Symbol("pi")  # the number, unless pi is a name that is known
SHORTHAND = re.compile(r"([sc])_?([0-9]+)")


def key_of(symbol: Symbol) -> Key:
    """The key that all spellings of one symbol have in common."""
    return symbol.letter + re.sub(r"[,_ ]", "", symbol.index), symbol.dots, symbol.accent + symbol.mark


def spelled(letters: str, index: str = "", dots: int = 0) -> Symbol:
    """The symbol of letters as a lexer found them, with index and dots: `qd` with index 1 is q dot 1."""
    read = symbol("_".join(filter(None, [letters, index.replace(",", "_")])))
    return Symbol(read.letter, read.index, min(read.dots + dots, 2), read.accent, read.mark)


@dataclass(frozen=True)
class Names:
    """The symbols that are known, by their keys, and those known by a path such as `links[0].mass`."""

    keys: Mapping[Key, Symbol]
    paths: Mapping[str, Symbol]

    @staticmethod
    def of(symbols: Iterable[Symbol], paths: Mapping[str, Symbol] | None = None) -> Names:
        """The table of these symbols."""
        return Names({key_of(symbol): symbol for symbol in symbols}, paths or {})

    def find(self, letters: str, index: str = "", dots: int = 0) -> Symbol | None:
        """The known symbol of that spelling, if there is one."""
        if not index and not dots and letters in self.paths:
            return self.paths[letters]
        return self.keys.get(key_of(spelled(letters, index, dots)))

    def split(self, token: Token) -> list[Symbol]:
        """The symbols that a name stands for: letters side by side in LaTeX may be several."""
        if (whole := self.find(token.text, token.index, token.dots)) is not None:
            return [whole]
        if token.text.isalpha() and not token.dots and (several := self._side_by_side(token)) is not None:
            return several
        raise refusal(token, self._unknown(token))

    def _side_by_side(self, token: Token) -> list[Symbol] | None:
        letters = token.text
        rest: dict[int, list[Symbol]] = {}  # from each letter on
        for start in range(len(letters) - 1, -1, -1):
            if (last := self.find(letters[start:], token.index)) is not None:
                rest[start] = [last]
                continue
            for end in range(len(letters) - 1, start, -1):
                if end in rest and (first := self.find(letters[start:end])) is not None:
                    rest[start] = [first, *rest[end]]
                    break
        return rest.get(0)

    def _unknown(self, token: Token) -> str:
        said = name_of(spelled(token.text, token.index, token.dots)) if token.index or token.dots else token.text
        letters = (symbol for symbol in self.keys.values() if not (symbol.bold and symbol.dots))
        known = sorted({name_of(symbol) for symbol in letters if "," not in symbol.index})
        near = difflib.get_close_matches(said[:60], [*known, *self.paths], n=1, cutoff=0.6)
        if short := SHORTHAND.fullmatch(said):
            angles = " + ".join(f"q_{digit}" for digit in short[2])
            function = "sin" if short[1] == "s" else "cos"
            advice = f" If it is short for {function}({angles}), declare it: `{said} = {function}({angles})`."
        elif "." in said:
            advice = (
                " A formula is no program: a path names a number of the robot, as links[0].length, and nothing else."
            )
        elif near:
            advice = f" Did you mean '{near[0]}'?"
        else:
            advice = f" Known are {', '.join(known[:20])}{', ...' if len(known) > 20 else ''}."
        return f"there is no '{cut(said)}' among the names of this robot, nor is it declared here.{advice}"
