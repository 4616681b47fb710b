"""Formulas in Typst: every one compiles, none leaves the page, and no name becomes code."""

import json

import casadi as ca
import pytest
import typst
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.core.notation import typst_math
from workbench.core.notation.build import number
from workbench.core.notation.formula import (
    ACCENTS,
    GREEK,
    Call,
    Matrix,
    Product,
    Quotient,
    Relation,
    Sum,
    Symbol,
    System,
    symbol,
)
from workbench.core.notation.reader import read

x, y, q2, qd = (ca.SX.sym(name) for name in ("x", "y", "q_2", "qd_1"))
X, Y = Symbol("x"), Symbol("y")


def asked(folder, sources, question):
    """What Typst says of each equation: the value of `question`, in which `eq` is the equation."""
    lines = [f"#context [#metadata({{ let eq = $ {source} $\n {question} }}) <answer>]" for source in sources]
    page = folder / "page.typ"
    page.write_text("#set text(11pt)\n" + "\n".join(lines), encoding="utf-8")
    return json.loads(typst.query(str(page), "<answer>", field="value"))


def widths(folder, sources):
    """Widths in widths of a digit, half of 11 pt."""
    return [width / 5.5 for width in asked(folder, sources, "measure(eq).width.pt()")]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("q_1", "q_(1)"),
        ("qd_1", "dot(q)_(1)"),
        ("qdd_2", "dot.double(q)_(2)"),
        ("Lambda", "Lambda"),
        ("tau_max1", 'tau_(upright("max") , 1)'),
        ("q_star_1", "q_(1)^(*)"),
        ("a.b", 'upright("a.b")'),
    ],
)
def test_a_symbol_is_written_with_its_dots_and_indices(name, expected):
    assert typst_math.emit(symbol(name)) == expected


def test_every_greek_letter_accent_and_function_is_known_to_typst(tmp_path):
    symbols = [Symbol(letter, "1", dots=1) for letter in GREEK]
    symbols += [Symbol("q", "r,1", dots=2, accent=accent, mark="*", bold=True) for accent in ACCENTS]
    functions = "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt sign floor ceil erf abs"
    calls = [Call(name, (Quotient(X, Y),)) for name in functions.split()] + [Call("min", (X, Y)), Call("mod", (X, Y))]
    assert all(width > 0 for width in widths(tmp_path, [typst_math.emit(f) for f in [*symbols, *calls]]))


formulas = st.recursive(
    st.sampled_from([x, y, q2, qd, ca.SX(2), ca.SX(0.1), ca.SX(1e-9), ca.SX(0.5)]),
    lambda inner: st.one_of(
        st.builds(lambda a, b: a + b, inner, inner),
        st.builds(lambda a, b: a - b, inner, inner),
        st.builds(lambda a, b: a * b, inner, inner),
        st.builds(lambda a, b: a / (2 + b**2), inner, inner),
        st.builds(lambda a, b: ca.if_else(ca.logic_and(a >= b, a != 0), a, ca.fmin(a, b)), inner, inner),
        st.builds(
            lambda f, a: f(a),
            st.sampled_from([ca.sin, ca.exp, ca.fabs, ca.sign, ca.ceil, lambda a: ca.sqrt(ca.fabs(a))]),
            inner,
        ),
        st.builds(lambda a: (1 + ca.sin(a)) ** 3, inner),
    ),
    max_leaves=12,
).map(read)


@settings(max_examples=10, deadline=None)
@given(st.lists(formulas, min_size=10, max_size=20))
def test_every_formula_compiles(tmp_path_factory, batch):
    sources = [typst_math.emit(Relation(symbol("tau_1"), "=", f), width=60) for f in batch]
    sources.append(typst_math.emit(Matrix((tuple(batch[:2]), tuple(batch[2:4])))))
    assert all(width > 0 for width in widths(tmp_path_factory.mktemp("page"), sources))


def test_no_equation_leaves_the_page(tmp_path):
    terms = [ca.SX.sym(f"m_{i}") * ca.SX.sym(f"M_{i}") * ca.cos(ca.SX.sym(f"omega_{i}")) for i in range(25)]
    long = sum(terms, ca.SX(0))
    expressions = [long, x * long, ca.exp(long), long**3, 1 / long, x / long, long / x, long / long**2, -long]
    expressions += [ca.sin(x * long), x - y * long, sum((ca.sin(t) for t in terms), ca.SX(0))]
    expressions += [terms[0] * terms[1] * terms[2] * terms[3] * terms[4] * terms[5], long * terms[0] * (long + x)]
    for width in (40, 60, 80):
        sources = [typst_math.emit(Relation(symbol("tau_1"), "=", read(e)), width=width) for e in expressions]
        assert all("\n" in source for source in sources)
        # Lines after the first are indented by two digits (one quad).
        assert max(widths(tmp_path, sources)) <= width + 2


def test_a_wide_matrix_is_written_entry_by_entry(tmp_path):
    entry = Sum(tuple(Symbol("a", str(i)) for i in range(12)))
    source = typst_math.emit(Relation(Symbol("M"), "=", Matrix(((X, entry), (entry, Y)))))
    assert source.count("\\\n") == 3
    assert "M_(21) & = M_(12)" in source
    assert max(widths(tmp_path, [source])) <= 80


HOSTILE = [
    '#eval("1")',
    '#read("/etc/passwd")',
    '"#read("x")"',
    '\\"',
    "\\",
    "$x$",
    "// a",
    "/* a",
    "*/",
    "]",
    "#",
    "&",
    ";",
    "a,b",
    "line\nbreak",
    "\u202eright to left",
    "\x00",
    "<label>",
    "é",
    "漢",
    "😀",
]


def test_a_hostile_name_is_text(tmp_path):
    symbols = [Symbol(name, name, mark=name) for name in HOSTILE] + [symbol(name) for name in HOSTILE]
    formulas = [Sum((s, Quotient(Call(s.letter, (s,)), s), Matrix(((s, s),)))) for s in symbols]
    answers = asked(tmp_path, [typst_math.emit(f, width=1e9) for f in formulas], "repr(eq)")
    for formula, answer in zip(formulas, answers, strict=True):
        shown = formula.terms[0].letter.translate(dict.fromkeys((0, 10, 0x202E), "\ufffd"))
        # Typst's repr shows content as code: text in brackets, or as a string within text(...).
        assert shown in answer or json.dumps(shown, ensure_ascii=False)[1:-1] in answer


@settings(max_examples=10, deadline=None)
@given(names=st.lists(st.text(), min_size=20, max_size=40))
def test_any_name_compiles(tmp_path_factory, names):
    sources = [typst_math.emit(Product((Symbol(name, name[:2]), symbol(name), number(2)))) for name in names]
    assert len(widths(tmp_path_factory.mktemp("page"), sources)) == len(names)


def test_a_page_of_equations_becomes_a_pdf(tmp_path):
    source = typst_math.emit(System((Relation(X, "=", Y), Relation(Y, "=", read(ca.sin(q2) * qd)))))
    assert typst.compile(f"$ {source} $".encode()).startswith(b"%PDF")
