"""Sheets of equations that nobody would print, each of its seed: right ones mutated, and formulas grown at random."""

import random


def _words(said: str) -> list[str]:
    return said.split()


TEXT = """# the arm of section 5
M[1,1] = m_1*l_1^2 + m_2*(l_1^2 + l_2^2 + 2*l_1*l_2*cos(q_2))
M_12 = M_21 = m_2*(l_2^2 + l_1*l_2*c_2)
M_22 = m_2*l_2**2
c_2 = cos(q_2)
C = [[-h*qd_2, -h*(qd_1 + qd_2)], [h*q_1', 0]]
h = m_2*l_1*l_2*sin(theta_2)
G = [(m_1 + m_2)*g*l_1*sin(q_1) + 9.81/9.81*m_2*g*l_2*sin(a), m_2*g*l_2*sin(q_1 + q_2)]
a = q_1 + q_2
"""
LATEX = r"""
\begin{equation}
M(q) = \begin{bmatrix}
 m_1 l_1^2 + m_2\left(l_1^2 + l_2^2 + 2 l_1 l_2 \cos q_2\right) & m_2 (l_2^2 + l_1 l_2 \cos q_2) \\
 m_2 (l_2^2 + l_1 l_2 \cos q_2) & \frac{m_2 l_2^{2}}{1}
\end{bmatrix}, \label{eq:2}
\end{equation}
\begin{align}
C(q,\dot q) &= \begin{bmatrix}
   -m_2l_1l_2 s_2\dot q_2 & -h (\dot q_1 + \dot{\theta}_2) \\ m_2 l_1 l_2 s_2 \dot{q}_1 & 0 \end{bmatrix} \\
G(q) &= \begin{pmatrix} (m_1+m_2) g l_1 \sin q_1 + m_2 g l_2 \sin(q_1+q_2) \\ m_2 g l_2 \sin(q_1+q_2) \end{pmatrix}
\end{align}
\[ s_2 = \sin q_2 \] $h = m_{2} l_{1} l_{2} s_{2}$
"""
NAMES = _words("""
    m_1 m_2 l_1 l_2 g q_1 q_2 qd_1 qd_2 q_1' theta_2' pi M_11 M[2,2] C_12 G_1 M h a_0 a_1 a_2 x x' M' I_1 links[0].mass
    links[0].length links[9].mass links[-1].mass __class__ m_1.__class__.__mro__ __import__ lambda None nan inf NaN
    e E i j 1j θ_2 θ̇ ℓ_1 µ ß ſ İ 𝑚_1 m₁ q² q³ ٣ ３ ½ _ __ a_ _1 m__1 M_0 M_1 M_111 M[0,0] M[99999999999999999999,1]
    M[1,1] G[1,1] G[3] m_1_1 m_1_1_1 qddd_1 dq_1 qdot_1 theta_1dot
""")
KNOWN = _words("m_1 m_2 l_1 l_2 q_1 q_2 qd_1 g h c_2 sin cos M C G")
ODD = [
    *"\x00\x01\x07\x08\x0b\x0c\r\x1b\x7f\x85\x9b\xa0\xad\u200b\u200d\u202e\u2028\u2066\ufeff\ufffe\ufffd\U0001f600",
    *"^_'\"`~!@#$%&|\\/?<>=;:,.()[]{}+-*·×−′″…–∞∂∫√",
    *("\x1b[2J", "\x1b]0;x\x07", "e\u0301", "\r\n", "\n\n", "**", "^^", "==", ":=", "!=", "..", "//", "{}", "()", "[]"),
]
MACROS = _words(r"""
    \frac \dfrac \sqrt \sin \cos \tan \dot \ddot \hat \bar \tilde \mathbf{M} \left \right \left( \right) \begin{bmatrix}
    \end{bmatrix} \begin{align} \end{align} \\ & \theta \ell \pi \input{/etc/passwd} \write18{id} \def\x{y} \csname \,
    ^\top ^T ^{T} _{12} _{1,2} ^{16} ^2 ^{-1} ^{1/2} \text{links[0].mass} \label{x} \cdot \times \begin{array}{cc} \over
    \frac12 \frac1{q_1} { } {{ }} $ $$ \[ \] \( \) \% % \lbrace \varphi \operatorname{sin} \sin^{2} \sin^2 \sin^{-1} \
""")


def sheet(seed: int) -> tuple[str, bytes]:
    """The name of a file, and what is in it."""
    dice = random.Random(seed)
    latex = dice.random() < 0.3
    if not latex and dice.random() < 0.5:
        said = _grown(dice)
    else:
        said = LATEX if latex else TEXT
        for _ in range(dice.choice((0, 1, 1, 1, 2, 3, 8, 40))):
            said = dice.choice(MUTATIONS)(said, dice, latex)
    ending = dice.choice((".tex", ".TEX", "") if latex else (".txt", ".txt", "", ".tex"))
    return f"sheet{ending}", _encoded(said, dice)


def _encoded(said: str, dice: random.Random) -> bytes:
    kind = dice.random()
    if kind < 0.03:
        return said.encode("utf-16")
    if kind < 0.05:
        return said.encode("latin-1", "replace")
    if kind < 0.08:
        return b"\xef\xbb\xbf" * dice.choice((1, 2)) + said.encode("utf-8", "surrogatepass")
    if kind < 0.11:
        return said.replace("\n", dice.choice(("\r\n", "\r", "\v", "\x85", "\u2028"))).encode()
    if kind < 0.13:
        return dice.randbytes(dice.choice((0, 1, 2, 100, 5000)))
    if kind < 0.15:
        whole = bytearray(said.encode())
        for _ in range(dice.choice((1, 3, 30))):
            whole[dice.randrange(len(whole) or 1) : 0] = dice.randbytes(1)
        return bytes(whole)
    return said.encode("utf-8", "surrogatepass")


def _at(said: str, dice: random.Random) -> int:
    return dice.randrange(len(said) + 1)


def _delete(said: str, dice: random.Random, latex: bool) -> str:
    i = _at(said, dice)
    return said[:i] + said[i + dice.choice((1, 1, 1, 2, 5, 30, 300)) :]


def _double(said: str, dice: random.Random, latex: bool) -> str:
    i = _at(said, dice)
    j = i + dice.choice((1, 1, 2, 5, 30, 300))
    return said[:j] + said[i:j] * dice.choice((1, 1, 2, 10, 100)) + said[j:]


def _swap(said: str, dice: random.Random, latex: bool) -> str:
    lines = said.splitlines()
    dice.shuffle(lines)
    return "\n".join(lines)


def _insert(said: str, dice: random.Random, latex: bool) -> str:
    i = _at(said, dice)
    what = dice.choice((ODD, NAMES, MACROS if latex or dice.random() < 0.1 else NAMES, ODD, [number(dice)]))
    return said[:i] + dice.choice(what) + said[i:]


def _other_name(said: str, dice: random.Random, latex: bool) -> str:
    return said.replace(dice.choice(KNOWN), dice.choice(NAMES), dice.choice((1, -1)))


def _raise(said: str, dice: random.Random, latex: bool) -> str:
    i = _at(said, dice)
    exponent = dice.choice(("2", "16", "-1", "1/2", "0", "-16", "17", "1e9", "(1/2)", "0.5", "q_1", number(dice)))
    left, right = ("{", "}") if latex else ("(", ")")
    once = f"^{left}{exponent}{right}" if latex or dice.random() < 0.5 else f"^{exponent}"
    return said[:i] + once * dice.choice((1, 1, 2, 3, 60)) + said[i:]


def _nest(said: str, dice: random.Random, latex: bool) -> str:
    i, depth = _at(said, dice), dice.choice((1, 5, 49, 50, 51, 500, 5000, 100_000))
    opening, closing = dice.choice(
        (
            ("(", ")"),
            ("{", "}"),
            ("[", "]"),
            ("sin(", ")"),
            ("-", ""),
            (r"\frac{1}{", "}"),
            (r"\sqrt{", "}"),
            (r"\dot{", "}"),
            ("1/(", ")"),
            ("(", ")^2"),
            ("2^", ""),
            ("[[", "]]"),
        )
    )
    inner = dice.choice(("q_1", "", "m_1 + 1", "0"))
    return said[:i] + opening * depth + inner + closing * (depth + dice.choice((0, 0, 0, 1, -1))) + said[i:]


def _long(said: str, dice: random.Random, latex: bool) -> str:
    i, what = (
        _at(said, dice),
        dice.choice((" ", "1", "m", "+m_1", "*q_1", "\\", "_", "a_1 = 1\n", "%", ",", "\n", "= ", "é")),
    )
    return said[:i] + what * dice.choice((100, 5_000, 60_000, 1_000_000)) + said[i:]


def _cut(said: str, dice: random.Random, latex: bool) -> str:
    return said[: _at(said, dice)]


MUTATIONS = (
    _delete,
    _delete,
    _double,
    _swap,
    _insert,
    _insert,
    _insert,
    _other_name,
    _other_name,
    _raise,
    _raise,
    _nest,
    _long,
    _cut,
)


def number(dice: random.Random) -> str:
    """A number as nobody writes it."""
    return dice.choice(
        (
            "0",
            "00",
            "1",
            "2",
            "3.5",
            ".5",
            "5.",
            "1e99",
            "1e-99",
            "1e100",
            "1e-400",
            "9" * 81,
            "0.1e1",
            "1e",
            "1e+",
            "1_000",
        )
        + (
            "1e99999999999",
            "0x10",
            "1e5e5",
            "1,5",
            "1.2.3",
            "1/3",
            "1/0",
            "0.000000001",
            "12345678901234567890",
            "9" * 80,
        )
    )


def _grown(dice: random.Random) -> str:
    """Declarations of declarations, in chains, trees and circles, and entries that use them."""
    count = dice.choice((0, 1, 3, 10, 31, 60, 400, 1000))
    shape = dice.choice(("chain", "chain", "circle", "tree", "any"))
    leaves = [
        "m_1",
        "l_1",
        "q_1",
        "q_2",
        "qd_1",
        "g",
        "2",
        "0",
        "pi",
        "sin(q_2)",
        "1/l_2",
        *([number(dice)] if dice.random() < 0.3 else []),
    ]
    growth = dice.choice(GROWTHS)
    lines = [f"a_0 = {_formula(dice, leaves, 2)}"]
    for i in range(1, count):
        before = f"a_{i - 1}" if shape != "any" else f"a_{dice.randrange(count)}"
        step = dice.choice(GROWTHS) if dice.random() < 0.05 else growth
        lines.append(f"a_{i} = {step.format(before, dice.choice(leaves))}")
    last = f"a_{max(count - 1, 0)}"
    if shape == "circle":
        lines[0] = f"a_0 = {last}"
    if dice.random() < 0.5:
        dice.shuffle(lines)
    entry = dice.choice(("M[1,1]", "M_22", "C_12", "G_1", "G[2]"))
    lines.append(f"{entry} = {dice.choice((last, last, _formula(dice, [*leaves, last], 5)))}")
    return "\n".join(lines)


GROWTHS = (
    *(
        "{0}",
        "{0} + {1}",
        "{0}*{1}",
        "{0} + {0}",
        "{0}*{0}",
        "{0}^2",
        "{0}^16",
        "sqrt({0})",
        "1/{0}",
        "-{0}",
        "{0}/{1}",
    ),
    *("sin({0})", "({0} + 1)^2", "{0}'", "({0} + {1})*({0} - {1})", "{0}^(-1)", "{0}^(1/2)", "1e99*{0}", "{0}^2 + {0}"),
)


FORMS = (
    *("({0}) + ({1})", "({0}) - ({1})", "({0})*({1})", "({0})/({1})", "({0})^2", "({0})^16", "({0})^(-3)"),
    *("({0})^(1/2)", "({0})^0", "sin({0})", "sqrt({0})"),
)


def _formula(dice: random.Random, leaves: list[str], depth: int) -> str:
    if depth == 0 or dice.random() < 0.1:
        return dice.choice(leaves)
    one, other = (_formula(dice, leaves, depth - 1) for _ in range(2))
    return dice.choice(FORMS).format(one, other)
