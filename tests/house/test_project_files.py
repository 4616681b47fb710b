"""The files that a host, a reader or a packager reads agree with the project."""

import re
import subprocess
import tomllib

import pytest

import workbench
from tests.house.sources import ROOT
from tests.support.kept_pages import PAGES
from workbench import DCMotor, cite
from workbench.study.citation import WORKBENCH

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
WORKFLOW = ROOT / ".github" / "workflows" / "tests.yml"


def line_of(path, start):
    """The value behind `start` in the only line of a file that begins with it."""
    (value,) = re.findall(rf"(?m)^\s*{re.escape(start)}\s*(.*)$", (ROOT / path).read_text())
    return value


def pythons_of_classifiers():
    prefix = "Programming Language :: Python :: 3."
    return ["3." + name.removeprefix(prefix) for name in PROJECT["project"]["classifiers"] if name.startswith(prefix)]


def test_a_citation_names_the_version_and_the_licence_of_the_package():
    assert line_of("CITATION.cff", "version:") == workbench.__version__
    assert line_of("CITATION.cff", "license:") == PROJECT["project"]["license"]
    assert line_of("CITATION.cff", "title:") == PROJECT["project"]["name"]


def test_the_workbench_cites_itself_as_the_citation_file_does():
    assert WORKBENCH.work == line_of("CITATION.cff", "title:")
    assert WORKBENCH.authors == line_of("CITATION.cff", "- name:")
    assert f"{WORKBENCH.authors}, {WORKBENCH.work}, version {line_of('CITATION.cff', 'version:')}." in repr(
        cite(DCMotor())
    )


def test_the_makefile_and_the_workflow_try_the_same_pythons_and_the_classifiers_name_some_of_them():
    tried = re.findall(r"3\.\d+", line_of(WORKFLOW, "python: ["))
    assert line_of("Makefile", "PYTHONS =").split() == [f"python{name}" for name in tried]
    assert tried[0] == PROJECT["project"]["requires-python"].removeprefix(">=")
    assert pythons_of_classifiers()
    assert set(pythons_of_classifiers()) <= set(tried)


def test_the_workflow_runs_commands_that_the_makefile_has():
    commands = re.findall(r"run: make (\S+)", WORKFLOW.read_text())
    rules = set(re.findall(r"(?m)^([\w-]+):", (ROOT / "Makefile").read_text()))
    assert set(commands) == {"paper", "check", "test-all", "docs"}
    assert set(commands) <= rules


def test_each_action_of_the_workflow_is_pinned_to_a_commit():
    actions = re.findall(r"uses: (\S+)", WORKFLOW.read_text())
    assert actions
    assert [name for name in actions if not re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", name)] == []


@pytest.mark.parametrize("tool", ["ruff check --quiet", "ruff format --check --quiet", "mypy --strict"])
def test_a_hook_runs_what_make_test_runs(tool):
    hooks = re.findall(r"entry: \.venv/bin/python -m (.*)", (ROOT / ".pre-commit-config.yaml").read_text())
    assert any(hook.startswith(tool) for hook in hooks)
    assert f"-m {tool}" in (ROOT / "Makefile").read_text()


def test_the_development_group_is_the_extra():
    assert PROJECT["dependency-groups"]["dev"] == [f"{PROJECT['project']['name']}[dev]"]
    assert "dev" in PROJECT["project"]["optional-dependencies"]


@pytest.mark.parametrize("name", ["CITATION.cff", "SECURITY.md", "RELEASE.md", "CONTRIBUTING.md"])
def test_a_source_archive_holds_the_files_that_a_packager_reads(name):
    assert (ROOT / name).is_file()
    assert f"/{name}" in PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]


@pytest.mark.skipif(
    not (ROOT / ".git").exists(), reason="git, which knows the files of the project, is in a checkout alone"
)
def test_a_source_archive_holds_all_files_at_the_top_and_a_wheel_the_package_alone():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split(
        "\n"
    )
    tops = {path.split("/")[0] for path in listed if path} - {".gitignore", "pyproject.toml"}  # hatch always adds these
    targets = PROJECT["tool"]["hatch"]["build"]["targets"]
    assert {pattern.split("/")[1] for pattern in targets["sdist"]["include"]} == tops
    assert targets["wheel"] == {"packages": ["workbench"]}


def test_a_checkout_has_the_pages_of_the_reports():  # else the tests of pages would be skipped in silence
    assert PAGES or not (ROOT / ".git").exists()


def test_each_check_of_the_repository_that_is_left_out_has_a_reason():
    reasons = PROJECT["tool"]["repo-review"]["ignore"]
    assert all(len(reason.split()) >= 5 for reason in reasons.values())
