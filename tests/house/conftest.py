"""What several files of this folder share."""

import pytest

from tests.support.small_exams import GRADER, PROBLEMS


@pytest.fixture
def exam(tmp_path):
    """A folder with one exam of simulation; its limit, and the problem that jumps, as given."""

    def write(limit="1e-6", jump="drag", grader=GRADER, name="motion"):
        folder = tmp_path / "exams" / name
        folder.mkdir(parents=True)
        (folder / "problems.py").write_text(f"{PROBLEMS}\nJUMP = {jump}\n", encoding="utf-8")
        (folder / "grade.py").write_text(grader.replace("LIMIT", limit), encoding="utf-8")
        return tmp_path / "exams"

    return write
