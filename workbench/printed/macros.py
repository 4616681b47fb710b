"""The macros and environments of LaTeX that formulas are read with, by what they mean; there are no others."""

from __future__ import annotations

from workbench.notation.formula import ACCENTS as OVER_LETTERS
from workbench.notation.formula import GREEK


def _words(said: str) -> frozenset[str]:
    return frozenset(said.split())


MATRICES = _words("matrix bmatrix pmatrix Bmatrix smallmatrix array")
DISPLAYS = _words(
    "equation align aligned alignat gather gathered split multline eqnarray flalign displaymath math document"
)
# What only moves signs on the page, or makes brackets larger.
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
