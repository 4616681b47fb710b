# make paper   the report on the paper, from a fresh clone, with the installation
# make reports the reports of all studies: fifteen minutes for series a and b; each later study says its own time
# make test    what must hold before a change is kept, in some five minutes
# make test-all   the same with the heaviest tests, each with every fourth of its cases
# make test-release   the same with all cases, and pages that are computed anew
# make test-pythons   the tests on each Python of PYTHONS that is here, in environments of their own
# make docs    the site with tutorial, how-tos, reference, theory and gallery, in docs/_site
# make env     the environment of both, without running anything
# make check   the paper's study in a new environment that holds only what users install
# make clean   remove the environments and caches; reports stay
#
# Another Python: make paper PYTHON=python3.12

PYTHON = python3
PYTHONS = python3.11 python3.12 python3.13 python3.14
STUDIES = studies/a0_two_link_arm.py studies/a1_paper_tables studies/a2_claims
ALL = $(basename $(notdir $(wildcard studies/[abcd][0-9]_*)))
LONGEST = a8_fair_comparison a7_sensitivity a6_unstated_choices
# c1 is about measured logs, which are kept elsewhere: make reports LOGS=FOLDER. Without them it is skipped.
export LOGS
# b4 counts the code of TinyMPC, whose sources are kept elsewhere: make reports TINYMPC=FOLDER. Without them it says so.
export TINYMPC
# a7 and a8 take the arm of a fit, and then have pages of their own: make reports FIT=arm.json (docs/howto/fit.md).
export FIT
SKIPPED = $(if $(LOGS),,$(filter c1_%,$(ALL)))
TIMED = b0_robots b2_sobol_cost# these measure time, and run alone
CODE = workbench studies tests docs
# One worker more than the threads of the processor (tests/conftest.py), up to four. Files run in the order of tests/conftest.py; xdist would begin with those that
# hold the most tests.
WORKERS = -n logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder
RUN = .venv/bin/python
PIP = -m pip -qq --disable-pip-version-check install --no-compile --constraint constraints.txt

.PHONY: paper reports test test-all test-release test-pythons docs env check clean python
.DEFAULT_GOAL := paper

paper: .venv/.runtime
	@set -e; for study in $(STUDIES); do $(RUN) -m workbench run $$study; done

reports: .venv/.dev
	@$(foreach study,$(SKIPPED),echo "$(study) is skipped: it needs measured logs, as in 'make reports LOGS=FOLDER'.";)
	@$(MAKE) --no-print-directory -j 2 $(addprefix report-,$(LONGEST) $(filter-out $(LONGEST) $(TIMED) $(SKIPPED),$(ALL)))
	@set -e; for study in $(TIMED); do $(RUN) -m workbench run studies/$$study; done

report-%:
	@$(RUN) -m workbench run $(firstword $(wildcard studies/$* studies/$*.py))

test: export PYTHONDONTWRITEBYTECODE = # else each process that a test starts would compile all modules again
test: .venv/.dev
	@echo "ruff";   $(RUN) -m ruff check --quiet $(CODE)
	@echo "format"; $(RUN) -m ruff format --check --quiet $(CODE)
	@echo "mypy, and beside it pytest with the architecture test"; \
	$(RUN) -m mypy --strict --no-error-summary & types=$$!; \
	$(RUN) -m pytest $(WORKERS) $(MARKED); tests=$$?; \
	wait $$types && exit $$tests

test-all: MARKED = -m "not release"
test-release: MARKED = -m ""
test-all test-release: test

test-pythons:
	@set -e; for python in $(PYTHONS); do \
		if command -v $$python > /dev/null && $$python -c '' 2> /dev/null; then \
			echo "$$python"; $$python -m venv --clear .venv-$$python; \
			.venv-$$python/bin/python $(PIP) --editable '.[dev]'; \
			.venv-$$python/bin/python -m pytest $(WORKERS); \
		else echo "$$python is not here: skipped"; fi; \
	done

docs: .venv/.docs
	@$(RUN) -m sphinx -q -W --keep-going -b html docs docs/_site
	@echo "The site is docs/_site/index.html."

env: .venv/.dev

.venv/.runtime: pyproject.toml constraints.txt
	@$(MAKE) --no-print-directory python
	@echo "Making .venv and installing what the workbench needs: about half a minute ..."
	@$(PYTHON) -m venv --clear .venv
	@$(RUN) $(PIP) --editable .
	@touch $@

.venv/.dev: pyproject.toml constraints.txt # at once, as two calls of pip build the project twice
	@$(MAKE) --no-print-directory python
	@echo "Making .venv and installing what the workbench and its tests need: about a minute ..."
	@$(PYTHON) -m venv --clear .venv
	@$(RUN) $(PIP) --editable '.[dev]'
	@touch .venv/.runtime $@

.venv/.docs: .venv/.runtime
	@echo "Installing what the site needs ..."
	@$(RUN) $(PIP) --editable '.[docs]'
	@touch $@

check:
	@$(MAKE) --no-print-directory python
	@echo "Installing the workbench as a user would, without its tests' packages ..."
	@$(PYTHON) -m venv --clear .venv-check
	@.venv-check/bin/python $(PIP) .
	@.venv-check/bin/python -m pip --disable-pip-version-check check
	@set -e; folder=$$(mktemp -d); trap 'rm -rf "$$folder"' EXIT; root=$$(pwd); cd "$$folder"; \
	for study in $(STUDIES); do \
		"$$root/.venv-check/bin/workbench" run "$$root/$$study" --out "$$folder/report"; \
		test -s "$$folder/report/index.html" && test -s "$$folder/report/report.pdf"; \
		rm -rf "$$folder/report"; \
	done
	@rm -rf .venv-check

clean:
	@rm -rf .venv .venv-check .venv-python* docs/_site docs/_studies docs/_reference docs/_static/*/ docs/notebooks .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis build dist
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +

python:
	@command -v $(PYTHON) > /dev/null || \
		{ echo "There is no '$(PYTHON)' here: name a Python of 3.11 or newer, as in 'make paper PYTHON=python3.12'." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "The workbench needs Python 3.11 or newer, and '$(PYTHON)' is $$($(PYTHON) -c 'import platform; print(platform.python_version())'): try 'make paper PYTHON=python3.12'." >&2; exit 1; }
