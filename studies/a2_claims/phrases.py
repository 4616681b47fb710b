"""From a claim as it is typed to a phrase as it is printed: x1~ with its tilde, qd_hat with hat and dot."""

import re
from dataclasses import replace
from fractions import Fraction

import workbench as wb

NAMES = (
    *("q_hat", "qd_hat", "D_hat", "q_d", "qd_d", "qdd_d", "qd_r", "qd", "L_D", "D_max", "lambda_min", "tau_1", "tau"),
    *("q_i", "qd_i", "e_i", "s_i", "D_i", "E_i", "K_i", "w_i", "k2_i", "Lambda_i", "e1", "e2", "x1", "x2"),
    *("L1", "L2", "P1", "P2", "V1", "V2", "alpha1", "alpha2", "alpha", "Lambda", "Delta", "rho", "delta", "sigma"),
    *("phi", "eta", "pi"),
)
PRIME_LETTERS = "MDKEPsqw"  # letters that are set as symbols where a prime follows
SIGNS = {
    "<=": "\N{LESS-THAN OR EQUAL TO}",
    ">=": "\N{GREATER-THAN OR EQUAL TO}",
    " - ": " \N{MINUS SIGN} ",
    "^2": "\N{SUPERSCRIPT TWO}",
    "^3": "\N{SUPERSCRIPT THREE}",
    "->": "\N{RIGHTWARDS ARROW}",
}
LONGEST_FIRST = "|".join(sorted(NAMES, key=len, reverse=True))
TOKEN = re.compile(
    rf"(?<![\w'\"])(?P<name>{LONGEST_FIRST}|[{PRIME_LETTERS}](?='(?!\w))|[A-Zs](?=\^T|\^-1))"
    r"(?P<tilde>~)?(?P<prime>'(?!\w))?(?P<power>\^T|\^-1)?(?!\w)"
)


def phrase(text: str) -> tuple[wb.document.Part, ...]:
    """The text with its symbols and signs set as formulas."""
    parts: list[wb.document.Part] = []
    end = 0
    for match in TOKEN.finditer(text):
        parts += [_signed(text[end : match.start()]), _formula(match)]
        end = match.end()
    parts.append(_signed(text[end:]))
    return tuple(part for part in parts if part != "")


def _formula(match: re.Match[str]) -> wb.notation.Formula:
    letter = wb.notation.symbol(match["name"])
    if match["tilde"]:
        letter = replace(letter, accent="tilde")
    if match["prime"]:
        letter = replace(letter, dots=letter.dots + 1)
    exponents: dict[str, wb.notation.Formula] = {"^T": wb.notation.Symbol("T"), "^-1": wb.notation.Number(Fraction(-1))}
    return wb.notation.Power(letter, exponents[match["power"]]) if match["power"] else letter


def _signed(text: str) -> str:
    for typed, sign in SIGNS.items():
        text = text.replace(typed, sign)
    return re.sub(r"(?<![\w)\]])-(?=[\w(|]|$)", "\N{MINUS SIGN}", text)
