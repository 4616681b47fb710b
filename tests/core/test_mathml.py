"""Formulas in MathML: elements that a browser typesets, and nothing else."""

from xml.etree import ElementTree

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.core.notation import mathml
from workbench.core.notation.formula import Call, Matrix, Product, Relation, Sum, Symbol, symbol
from workbench.core.notation.reader import read

CHILDREN = {"mfrac": 2, "msup": 2, "msub": 2, "msubsup": 3, "mover": 2}
CORE = {"math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "msqrt", "mtable", "mtr", "mtd", *CHILDREN}
NAMES = "display displaystyle style mathvariant form fence stretchy accent lspace rspace separator width"
ATTRIBUTES = set(NAMES.split())
x, y, q2, qd = (ca.SX.sym(name) for name in ("x", "y", "q_2", "qd_1"))
X, Y = Symbol("x"), Symbol("y")


def parsed(source):
    """The tree of a formula, each element known to MathML Core and with as many children as it takes."""
    tree = ElementTree.fromstring(source)
    for element in tree.iter():
        assert element.tag in CORE
        assert len(element) == CHILDREN.get(element.tag, len(element))
        assert set(element.attrib) <= ATTRIBUTES
    return tree


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("q_1", "<msub><mi>q</mi><mn>1</mn></msub>"),
        ("qd_1", '<msub><mover accent="true"><mi>q</mi><mo>\u02d9</mo></mover><mn>1</mn></msub>'),
        ("qdd", '<mover accent="true"><mi>q</mi><mo>\u00a8</mo></mover>'),
        ("Lambda", '<mi mathvariant="normal">Λ</mi>'),
        ("tau", "<mi>τ</mi>"),
        ("q_star", "<msup><mi>q</mi><mo>*</mo></msup>"),
        ("a.b", "<mi>a.b</mi>"),
    ],
)
def test_a_symbol_is_marked_up_with_its_dots_and_indices(name, expected):
    assert mathml.emit(symbol(name)) == f'<math display="block">{expected}</math>'


def test_dots_are_spacing_marks_which_browsers_place_well():
    source = mathml.emit(Product((symbol("qd"), symbol("qdd"), symbol("q_hat"))))
    assert not any("\u0300" <= character <= "\u036f" for character in source)


def test_a_power_of_an_indexed_symbol_stands_above_its_index():
    assert "<msubsup><mi>q</mi><mn>2</mn><mn>2</mn></msubsup>" in mathml.emit(read(q2**2))


def test_a_formula_is_on_a_line_of_its_own_or_in_the_text():
    assert mathml.emit(X).startswith('<math display="block">')
    assert mathml.emit(X, display=False).startswith("<math>")
    long = Sum(tuple(Symbol("a", str(i)) for i in range(60)))
    assert "mtable" in mathml.emit(long)
    assert "mtable" not in mathml.emit(long, display=False)


@given(
    st.recursive(
        st.sampled_from([x, y, q2, qd, ca.SX(2), ca.SX(0.1), ca.SX(1e-9), ca.SX(0.5)]),
        lambda inner: st.one_of(
            st.builds(lambda a, b: a + b, inner, inner),
            st.builds(lambda a, b: a - b, inner, inner),
            st.builds(lambda a, b: a * b, inner, inner),
            st.builds(lambda a, b: a / (2 + b**2), inner, inner),
            st.builds(lambda a, b: ca.if_else(a >= b, a, ca.fmin(a, b)), inner, inner),
            st.builds(
                lambda f, a: f(a),
                st.sampled_from([ca.sin, ca.exp, ca.fabs, ca.sign, ca.ceil, lambda a: ca.sqrt(ca.fabs(a))]),
                inner,
            ),
            st.builds(lambda a: (1 + ca.sin(a)) ** 3, inner),
        ),
        max_leaves=12,
    ),
    st.integers(10, 100),
)
def test_every_formula_is_well_formed_mathml_core(expression, width):
    formula = Relation(symbol("tau_1"), "=", read(ca.horzcat(expression, 1)))
    assert parsed(mathml.emit(formula, width=width)) is not None


@given(st.text(), st.text(max_size=3))
def test_a_hostile_name_is_inert(name, index):
    tree = parsed(mathml.emit(Sum((Symbol(name, index, mark=index), Call(name, (symbol(name),))))))
    assert tree.tag == "math"


def test_no_element_gets_through_a_name():
    source = mathml.emit(Product((symbol("<script>alert(1)</script>"), Symbol("a", '"><img onerror=x>'))))
    assert "<script" not in source
    assert "<img" not in source
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in source


def test_a_wide_matrix_is_written_entry_by_entry():
    entry = Sum(tuple(Symbol("a", str(i)) for i in range(12)))
    tree = parsed(mathml.emit(Relation(Symbol("M"), "=", Matrix(((X, entry), (entry, Y))))))
    assert len(tree.findall("./mtable/mtr")) == 4
