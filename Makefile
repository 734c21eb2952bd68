# `make` lists the targets. Only Python 3.11 or newer is needed: all else is installed into .venv.

# Python 3.11 comes first, because pybullet has wheels for it only. Each candidate is run: a version
# manager can have a program on the PATH for a Python that isn't installed.
CANDIDATES = python3.11 python3 python3.12 python3.13 python
FIT = -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))'
PYTHON ?= $(shell for python in $(CANDIDATES); do \
	"$$python" $(FIT) 2>/dev/null && { echo "$$python"; break; }; done)

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# Ghostball and its compiler alone: enough for the commands, but not for tests and checks.
USABLE := $(VENV)/.usable
OUT ?= out
JOBS ?= 2
# File with the versions to install; with CONSTRAINTS= pip installs the newest ones.
CONSTRAINTS ?= constraints.txt
# Extras of ghostball to install; EXTRAS=test is enough for `make test`.
EXTRAS ?= dev
INSTALL := $(BIN)/python -m pip install --disable-pip-version-check \
	$(if $(CONSTRAINTS),--constraint $(CONSTRAINTS))
# Scenes of `make validate`, as names, tags or patterns; smoke is a small selection.
SCENES ?= full
# Pictures beside the report: png, svg (both formats) or none.
FIGURES ?= png
# With more threads, numpy's library of linear algebra keeps all processors busy for matrices so
# small that a single thread is faster, while the other workers need the processors.
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --quiet --numprocesses $(JOBS)
# Python caches bytecode even if the caller's environment forbids it. Without the cache, each of
# hundreds of processes compiles its modules: collecting the tests takes 12 s instead of 4 s.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
# Two targets at once would mix their output, except with SIDE_BY_SIDE.
ifndef SIDE_BY_SIDE
.NOTPARALLEL:
endif
.PHONY: help venv engines smoke validate regress stress kernels test test-slow test-nojit coverage \
	coverage-of-changes lock \
	test-boundscheck lint docs docs-outputs lint-and-docs check wheel gallery peers peers-js clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-20s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

venv: $(READY)  ## create the environment .venv and install everything

$(USABLE): pyproject.toml $(CONSTRAINTS)
	@test -n "$(PYTHON)" && $(PYTHON) $(FIT) || { \
		echo "error: Python 3.11 or newer with its venv module is needed, got '$(PYTHON)'." \
			"Tried: $(CANDIDATES). Install one (Debian, Ubuntu: apt install python3-venv)," \
			"or name one: make PYTHON=/path/to/python3.11" >&2; exit 2; }
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || { \
		echo "Creating $(VENV) with $$($(PYTHON) --version)"; $(PYTHON) -m venv --clear $(VENV); }
	@echo "Installing Ghostball and the packages that it needs into $(VENV) (220 MB, one or two minutes)"
	@$(INSTALL) --editable '.[compiler]'
	@touch $@

$(READY): $(USABLE)
	@echo "Installing the packages for tests and checks into $(VENV) (a minute or two)"
	@$(INSTALL) --editable '.[$(EXTRAS)]'
	@touch $@

smoke: $(USABLE)  ## a first result in minutes: three scenes on three engines, a picture, and the report
	@echo "Simulating three shots on three engines. The first run compiles the engine."
	$(BIN)/ghostball validate half-ball-cut thin-cut break-7 -e ghostball -e pymunk -e paper-continuous \
		--jobs $(JOBS) --out $(OUT)/smoke
	$(BIN)/ghostball run break-7 --plot $(OUT)/smoke/break-7.png
	@echo "Next: open $(OUT)/smoke/report.html in a browser. \`make validate\` runs every scene;" \
		"README.md shows how to test an engine of your own"

engines: $(READY)  ## install the optional engines, about 500 MB
	$(INSTALL) --editable '.[engines]'

validate: $(USABLE)  ## run every scene on the default engines, print the verdicts, write the report
	$(BIN)/ghostball validate $(SCENES) --jobs $(JOBS) --out $(OUT) --figures $(FIGURES)

stress: kernels  ## run extreme shots on the default engines, the selection for CI
	$(BIN)/ghostball stress --jobs $(JOBS) --out $(OUT)/stress

regress: $(USABLE)  ## compare Ghostball's engine with its accepted baselines
	$(BIN)/ghostball regress --jobs $(JOBS) --out $(OUT)

# COVERAGE=1 measures coverage in `make test`, which then takes two thirds longer.
COVERAGE ?=
# Compiled kernels can't be traced, so `test-nojit` runs their tests without compilation. `test`
# traces all other code. The coverage combines both runs.
COVER := --cov --cov-report= --cov-fail-under=0
with_coverage = $(if $(COVERAGE),COVERAGE_FILE=.coverage.$(1) $(PYTEST) $(COVER),\
	rm -f .coverage.$(1) && $(PYTEST))

# Kernels that changed are compiled before the tests. Compiling takes minutes, and the workers of
# pytest would wait for each other.
COMPILE := $(BIN)/python tests/support/compile_kernels.py $(JOBS)

kernels: $(READY)  ## compile the kernels that the tests need
	$(COMPILE)

# Without COVERAGE, the data of an older run are deleted, because `coverage` would combine them.
test: kernels  ## run the fast tests with compiled kernels; COVERAGE=1 measures their coverage
	$(call with_coverage,compiled) --durations=10

# Only the files with slow tests: collecting all files takes each process ten seconds.
SLOW = tests/browser $(shell grep -rl --include='test_*.py' 'mark\.slow' tests)

# With `worksteal`, an idle worker takes tests from others; some tests wait a minute for processes.
test-slow: kernels  ## run the slow tests
	$(PYTEST) --dist worksteal -m slow --durations=10 $(SLOW)

# These tests cover every line and branch of the kernels that any test covers, in a quarter of the
# time, and check shots against their baselines bit for bit (`test_shot.py`). With `loadfile`, the
# tests of a file share their fixtures.
test-nojit: $(READY)  ## run tests of every line of the kernels, without compilation
	export NUMBA_DISABLE_JIT=1; $(call with_coverage,interpreted) \
		--dist loadfile -m "not slow and not compiled" tests/engine

coverage: COVERAGE := 1

coverage: engines test test-nojit  ## run both kinds of tests and print their coverage
	$(BIN)/coverage combine --keep --quiet .coverage.compiled .coverage.interpreted
	$(BIN)/coverage report

# Branch to compare with; CI requires this coverage for a pull request.
BASE ?= origin/main

coverage-of-changes: $(READY)  ## after `coverage`: print the coverage of lines changed since BASE; fail below 95 %
	$(BIN)/coverage xml --fail-under=0 -o $(OUT)/coverage.xml
	$(BIN)/diff-cover $(OUT)/coverage.xml --compare-branch $(BASE) --fail-under 95

lock:  ## update constraints.txt to the newest versions, in a new environment
	rm -rf .venv-lock
	$(MAKE) venv engines VENV=.venv-lock CONSTRAINTS=
	head -2 constraints.txt > .venv-lock/constraints.txt
	.venv-lock/bin/python -m pip freeze --exclude-editable >> .venv-lock/constraints.txt
	mv .venv-lock/constraints.txt constraints.txt
	rm -rf .venv-lock

# Only compiled bounds checks detect a negative index that wraps. These tests run every module of
# kernels. With less optimisation, checks and results are the same, and compiling takes three
# quarters of the time.
CHECKED := NUMBA_BOUNDSCHECK=1 NUMBA_OPT=1
BOUNDED := impacts resting_contact scheduling test_batch.py test_shot.py

test-boundscheck: $(READY)  ## run tests of the kernels with bounds checks
	$(CHECKED) $(COMPILE)
	$(CHECKED) $(PYTEST) --dist loadfile $(addprefix tests/engine/,$(BOUNDED))

lint: $(READY)  ## run pre-commit: ruff (rules, format), mypy, import contracts
	$(BIN)/pre-commit run --all-files

# Kernels first: a command that compiles prints a line about it, which would be part of its output.
# Material prints an advertisement for its successor at each build.
docs: kernels  ## check the outputs of changed pages, and build the documentation into build/site
	$(OUTPUTS) --check
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build

docs-outputs: kernels  ## write the outputs of the commands and tables into the pages of docs/
	$(OUTPUTS)

OUTPUTS = PATH="$(abspath $(BIN)):$$PATH" COLUMNS=90 $(BIN)/python -m docs.outputs

# Each of the two uses one processor, so they run at the same time.
lint-and-docs: $(READY)
	$(MAKE) --jobs 2 --output-sync=target --keep-going SIDE_BY_SIDE=1 lint docs

check: lint-and-docs test test-nojit stress test-slow test-boundscheck  ## run all checks, except coverage

# First the wheel is installed as a user installs it, without extras, and validated in an empty
# folder: its kernels must work without a compiler. Then the tests run in a copy without the sources,
# so that a file missing from the wheel makes them fail.
WHEEL := $(OUT)/wheel
WHEEL_BIN := $(abspath .venv-wheel)/bin

wheel: $(READY)  ## build the source archive and the wheel, and test the wheel in .venv-wheel
	rm -rf $(WHEEL)
	GHOSTBALL_BUILD_KERNELS=1 $(BIN)/python -m build --outdir $(WHEEL) . >/dev/null
	$(BIN)/python -m venv --clear .venv-wheel
	$(WHEEL_BIN)/python -m pip install --quiet --disable-pip-version-check $(WHEEL)/*.whl
	! $(WHEEL_BIN)/python -c 'import numba' 2>/dev/null
	empty=$$(mktemp -d) && cd $$empty && GHOSTBALL_CACHE_DIR=$$empty/cache $(WHEEL_BIN)/ghostball validate smoke --jobs $(JOBS) && \
		test ! -e cache/libraries && rm -rf $$empty
	$(WHEEL_BIN)/python -m pip install --quiet --disable-pip-version-check "$$(echo $(WHEEL)/*.whl)[dev]"
	cp -R tests benchmarks docs paper .github .ci Makefile *.md action.yml CITATION.cff pyproject.toml hatch_build.py constraints.txt $(WHEEL)
	cd $(WHEEL) && $(WHEEL_BIN)/python tests/support/compile_kernels.py $(JOBS)
	cd $(WHEEL) && $(WHEEL_BIN)/python -m pytest --quiet --numprocesses $(JOBS) -m "not slow and not checkout"

# Scenes and engines for the pictures of the paper's section 6.
SECTIONS := wall-bounce masse sliding-swerve air-rolls restitution-bounce flight-jump
SECTION_ENGINES := ghostball pymunk pymunk:contact_steps=exact pybullet pybullet:contact_steps=exact paper-discrete \
	paper-continuous mujoco physx:cloth=own dart:cloth=own

# Exit status 1 is accepted: engines that fail in these shots are drawn, too.
gallery: engines validate  ## update the pictures of the README and the documentation
	$(BIN)/ghostball validate $(SECTIONS) $(addprefix -e ,$(SECTION_ENGINES)) --jobs $(JOBS) \
		--out $(OUT)/sections --no-report || test $$? -eq 1
	$(BIN)/python -m benchmarks gallery $(OUT) docs/pictures --sections $(OUT)/sections

peers:  ## install other billiards engines into .venv-peers
	@test -n "$(PYTHON)" && $(PYTHON) $(FIT) || { \
		echo "error: Python 3.11 or newer is needed, got '$(PYTHON)'" >&2; exit 2; }
	$(PYTHON) -m venv --clear .venv-peers
	.venv-peers/bin/python -m pip install --quiet --disable-pip-version-check \
		--requirement reference_adapters/workers/scripts/requirements.txt
	@# Without its dependencies, because no index has the version of panda3d that it requires.
	.venv-peers/bin/python -m pip install --quiet --disable-pip-version-check --no-deps \
		pooltool-billiards==0.6.0

peers-js:  ## install the JavaScript engines into .peers-js; needs Node.js 18 or newer
	@command -v npm >/dev/null || { \
		echo "error: npm is needed. It comes with Node.js 18 or newer (Debian, Ubuntu: apt install npm)" >&2; exit 2; }
	mkdir -p .peers-js
	cp reference_adapters/javascript/driver/package.json reference_adapters/javascript/driver/package-lock.json .peers-js
	npm ci --prefix .peers-js --no-audit --no-fund --loglevel error

clean:  ## remove environments and caches, but not results
	rm -rf $(VENV) .venv-peers .peers-js .venv-wheel .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache \
		.coverage .coverage.* htmlcov build
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
