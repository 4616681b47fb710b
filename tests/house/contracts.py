"""The contracts of import-linter, checked in the house or in a copy of it that is broken."""

import shutil
import subprocess
import sys
from pathlib import Path

from tests.house import sources


def broken(tmp_path, cases):
    """What the linter says of a copy of the house with these lines in it."""
    shutil.copytree(sources.ROOT / "workbench", tmp_path / "workbench", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(sources.ROOT / "pyproject.toml", tmp_path)
    for file, text, _ in cases:
        with (tmp_path / "workbench" / file).open("a", encoding="utf-8") as handle:
            handle.write(f"\n{text}\n")
    done = lint_imports(tmp_path)
    assert done.returncode == 1
    return done.stdout


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Check the contracts of the house that stands in `folder`."""
    call = [sys.executable, "-m", "importlinter.cli", "lint-imports"]
    script = "import sys; sys.path.insert(0, ''); from importlinter.cli import lint_imports_command as c; c()"
    call = [sys.executable, "-c", script, "--no-cache", "--no-logo"]
    return subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
