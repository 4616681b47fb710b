"""Every law of the gallery has the bits of its simulation in Python, and in C from each compiler and level by turns."""

import pytest

from tests.support.c_runs import COMPILERS, compiled, differing, needs_compiler, recorded
from tests.support.digital_laws import digital, gallery
from tests.support.law_forms import Record, agree, run_here
from workbench.handover.c99.c_files import c_code
from workbench.handover.programs.python_law import python_law

OPTIONS = ("-O0", "-O1", "-O2", "-O3")
BOTH_ENDS = "AOSMC-RGS", "RBF-ASMC", "LQG, quadruple tank P−"  # which have the lowest and the highest level of one
INSTANTS, IN_PYTHON = 300, 50  # of which an interpreter takes a millisecond each


def ways_of(number, name):
    """A compiler and a level for each law by turns."""
    if name in BOTH_ENDS:
        return [(COMPILERS[0], option) for option in (OPTIONS[0], OPTIONS[-1])]
    return [(COMPILERS[number % len(COMPILERS)], OPTIONS[number // len(COMPILERS) % len(OPTIONS)])]


@needs_compiler
@pytest.mark.heavy
@pytest.mark.parametrize(("number", "name"), list(enumerate(gallery())))
def test_a_law_of_the_gallery_has_its_bits_in_c_and_in_python(tmp_path, number, name):
    sampled, law = digital(name)
    y, r, u, z = recorded(sampled, law, INSTANTS)
    code = c_code(law, "law")
    for way in ways_of(number, name):
        (folder := tmp_path / "".join(way)).mkdir()
        found = compiled(code, folder, way[0], way[1:])(y, r)
        assert (differing(found[0], u), differing(found[1], z), found[2].max()) == (0, 0, 0), (name, *way)
    rows = Record(law, *(part[:IN_PYTHON] for part in (y, r, u, z)))
    agree(rows, run_here(rows, python_law(law)))
