"""Every law of the gallery has the bits of its simulation in Python, and in C from each compiler and level by turns."""

import pytest

from tests.support.c_runs import COMPILERS, compiled, differing, needs_compiler, recorded
from tests.support.digital_laws import digital, gallery
from tests.support.law_forms import Record, agree, replayed
from workbench.handover.c99.c_code import c_code
from workbench.handover.programs.python_law import python_law

OPTIONS = ("-O0", "-O1", "-O2", "-O3")
IN_PYTHON = 100  # instants, of which an interpreter takes a millisecond each


@needs_compiler
@pytest.mark.heavy
def test_every_law_of_the_gallery_has_its_bits_in_c_and_in_python(tmp_path):
    for number, name in enumerate(gallery()):
        sampled, law = digital(name)
        y, r, u, z = recorded(sampled, law, 300)
        # each level of each compiler by turns; tests of `c_code` have both ends of one for four of the laws
        way = COMPILERS[number % len(COMPILERS)], OPTIONS[number // len(COMPILERS) % len(OPTIONS)]
        (folder := tmp_path / f"{number}{''.join(way)}").mkdir()
        found = compiled(c_code(law, "law"), folder, way[0], way[1:])(y, r)
        assert (differing(found[0], u), differing(found[1], z), found[2].max()) == (0, 0, 0), (name, *way)
        rows = Record(law, *(part[:IN_PYTHON] for part in (y, r, u, z)))
        agree(rows, replayed(rows, python_law(law), folder))
