# `make` lists the commands. Needs Python 3.11 or newer and nothing else: the rest is made in .venv.

# pybullet has wheels for 3.11 only, so that version comes first. Each candidate is run, not just
# looked up: a version manager's shim is on the PATH also where the interpreter behind it is not.
CANDIDATES = python3.11 python3 python3.12 python3.13 python
FIT = -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))'
PYTHON ?= $(shell for python in $(CANDIDATES); do \
	"$$python" $(FIT) 2>/dev/null && { echo "$$python"; break; }; done)

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
OUT ?= out
JOBS ?= 2
# Versions that are installed; CONSTRAINTS= takes the newest of all.
CONSTRAINTS ?= constraints.txt
# What is installed beside ghostball; EXTRAS=test is enough for `make test`.
EXTRAS ?= dev
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check \
	$(if $(CONSTRAINTS),--constraint $(CONSTRAINTS))
# Names, tags or patterns; smoke is a small run.
SCENES ?= full
# Which pictures lie beside the report: png, svg (both) or none.
FIGURES ?= png
PYTEST := $(BIN)/python -m pytest --quiet --numprocesses $(JOBS)
# Where bytecode isn't kept, each of hundreds of processes compiles every module that it imports:
# three seconds to load the suite instead of one, twelve to collect the tests instead of four.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
# Two test runs at once would mix their output.
ifndef SIDE_BY_SIDE
.NOTPARALLEL:
endif
.PHONY: help venv engines smoke validate regress stress kernels test test-slow test-nojit coverage \
	coverage-of-changes lock \
	test-boundscheck lint docs docs-outputs lint-and-docs check wheel gallery peers peers-js clean

help:  ## list the commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-18s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

venv: $(READY)  ## make the environment in .venv and install everything

$(READY): pyproject.toml $(CONSTRAINTS)
	@test -n "$(PYTHON)" && $(PYTHON) $(FIT) || { \
		echo "error: Python 3.11 or newer with its venv module is needed, got '$(PYTHON)'." \
			"Looked for: $(CANDIDATES). Install one (Debian, Ubuntu: apt install python3-venv)," \
			"or name it: make PYTHON=/path/to/python3.11" >&2; exit 2; }
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || { \
		echo "Making $(VENV) with $$($(PYTHON) --version)"; $(PYTHON) -m venv --clear $(VENV); }
	@echo "Installing ghostball and what it needs into $(VENV) (a minute or two)"
	@$(INSTALL) --editable '.[$(EXTRAS)]'
	@touch $@

smoke: $(READY)  ## a first result, in minutes: three scenes on three engines, a picture, the page
	$(BIN)/ghostball validate half-ball-cut thin-cut break-7 -e ghostball -e pymunk -e paper-continuous \
		--jobs $(JOBS) --out $(OUT)/smoke
	$(BIN)/ghostball run break-7 --plot $(OUT)/smoke/break-7.png
	@echo "Next: open $(OUT)/smoke/report.html in a browser. \`make validate\` runs every scene;" \
		"\`. $(BIN)/activate && ghostball init\` writes an engine to begin with"

engines: $(READY)  ## install the optional engines to compare with, some 500 MB
	$(INSTALL) --editable '.[engines]'

validate: $(READY)  ## run every scene on the default engines, write the report, print the verdicts
	$(BIN)/ghostball validate $(SCENES) --jobs $(JOBS) --out $(OUT) --figures $(FIGURES)

stress: kernels  ## try to break the default engines: what CI has time for
	$(BIN)/ghostball stress --jobs $(JOBS) --out $(OUT)/stress

regress: $(READY)  ## compare our engine with its accepted baselines
	$(BIN)/ghostball regress --jobs $(JOBS) --out $(OUT)

# Coverage makes tests slower by two thirds, so `make test` leaves it out; COVERAGE=1 asks for it.
COVERAGE ?=
# What is compiled can't be traced: some tests of the kernels run again without compilation. Those of
# all else trace it as they run in any case, in `test`; both together are the coverage.
COVER := --cov --cov-report= --cov-fail-under=0
with_coverage = $(if $(COVERAGE),COVERAGE_FILE=.coverage.$(1) $(PYTEST) $(COVER),\
	rm -f .coverage.$(1) && $(PYTEST))

# Compiling takes minutes: each variant of the kernels that changed since is compiled once, before the
# tests, whose workers would else wait for each other.
COMPILE := $(BIN)/python tests/support/compile_kernels.py $(JOBS)

kernels: $(READY)
	$(COMPILE)

# Without coverage none of an older run may stay: `coverage` would take it for this run's.
test: kernels  ## fast tests, compiled; prints the ten that took longest; COVERAGE=1 measures their coverage too
	$(call with_coverage,compiled) --durations=10

# Of the files that have any: to collect all the others takes each process ten seconds.
SLOW = tests/browser $(shell grep -rl --include='test_*.py' 'mark\.slow' tests)

# Each takes over what is left of another's share: some wait a minute for processes that they start.
test-slow: kernels  ## the tests that take long
	$(PYTEST) --dist worksteal -m slow --durations=10 $(SLOW)

# Every line and branch of a kernel that some test runs is run by these too, in a quarter of the time,
# and shots have the bits of their baselines (`test_shot.py`). Each file's tests share what they load.
test-nojit: $(READY)  ## tests that run every line of the kernels, without compilation
	export NUMBA_DISABLE_JIT=1; $(call with_coverage,interpreted) \
		--dist loadfile -m "not slow and not compiled" tests/engine

coverage: COVERAGE := 1

coverage: engines test test-nojit  ## coverage of both runs
	$(BIN)/coverage combine --keep --quiet .coverage.compiled .coverage.interpreted
	$(BIN)/coverage report

# Of a branch: what CI asks of a pull request.
BASE ?= origin/main

coverage-of-changes: $(READY)  ## after `coverage`: that of the lines that differ from BASE; fails below 95 %
	$(BIN)/coverage xml --fail-under=0 -o $(OUT)/coverage.xml
	$(BIN)/diff-cover $(OUT)/coverage.xml --compare-branch $(BASE) --fail-under 95

lock:  ## write constraints.txt anew: the newest versions, in an environment of their own
	rm -rf .venv-lock
	$(MAKE) venv engines VENV=.venv-lock CONSTRAINTS=
	head -2 constraints.txt > .venv-lock/constraints.txt
	.venv-lock/bin/python -m pip freeze --exclude-editable >> .venv-lock/constraints.txt
	mv .venv-lock/constraints.txt constraints.txt
	rm -rf .venv-lock

# A negative index that wraps is seen by compiled bounds checks alone. These tests run every module
# of kernels. Checks are the same where the optimiser does less, and so is every bit: it compiles in
# three quarters of the time.
CHECKED := NUMBA_BOUNDSCHECK=1 NUMBA_OPT=1
BOUNDED := impacts resting_contact scheduling test_batch.py test_shot.py

test-boundscheck: $(READY)  ## tests of the kernels with bounds checks
	$(CHECKED) $(COMPILE)
	$(CHECKED) $(PYTEST) --dist loadfile $(addprefix tests/engine/,$(BOUNDED))

lint: $(READY)  ## what pre-commit runs: ruff (rules, format), mypy, the direction of imports
	$(BIN)/pre-commit run --all-files

# Kernels first: a command that compiles prints a line about it, which would be part of its output.
# Material prints an advertisement for its successor at each build.
docs: kernels  ## the documentation, into build/site; runs the commands of changed pages; a different output or a warning fails
	$(OUTPUTS) --check
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build

docs-outputs: kernels  ## write the outputs of the commands and tables into the pages of docs/
	$(OUTPUTS)

OUTPUTS = PATH="$(abspath $(BIN)):$$PATH" COLUMNS=90 $(BIN)/python -m docs.outputs

# Each takes one processor: side by side they take as long as the longer one.
lint-and-docs: $(READY)
	$(MAKE) --jobs 2 --output-sync=target --keep-going SIDE_BY_SIDE=1 lint docs

check: lint-and-docs test test-nojit stress test-slow test-boundscheck  ## all checks, but coverage

# What a user installs, without the extras, in an empty folder: with the kernels that came in the
# wheel, and no compiler. Then the tests, where no file of the checkout is imported by accident: what
# the wheel lacks fails here.
WHEEL := $(OUT)/wheel
OF_WHEEL := $(abspath .venv-wheel)/bin

wheel: $(READY)  ## build the source archive, the wheel from it, install that in an environment of its own, .venv-wheel, validate and test with it there
	rm -rf $(WHEEL)
	GHOSTBALL_BUILD_KERNELS=1 $(BIN)/python -m build --outdir $(WHEEL) . >/dev/null
	$(BIN)/python -m venv --clear .venv-wheel
	$(OF_WHEEL)/python -m pip install --quiet --disable-pip-version-check $(WHEEL)/*.whl
	! $(OF_WHEEL)/python -c 'import numba' 2>/dev/null
	empty=$$(mktemp -d) && cd $$empty && GHOSTBALL_CACHE_DIR=$$empty/cache $(OF_WHEEL)/ghostball validate smoke --jobs $(JOBS) && \
		test ! -e cache/libraries && rm -rf $$empty
	$(OF_WHEEL)/python -m pip install --quiet --disable-pip-version-check "$$(echo $(WHEEL)/*.whl)[dev]"
	cp -R tests benchmarks docs paper .github .ci Makefile *.md action.yml CITATION.cff pyproject.toml hatch_build.py constraints.txt $(WHEEL)
	cd $(WHEEL) && $(OF_WHEEL)/python tests/support/compile_kernels.py $(JOBS)
	cd $(WHEEL) && $(OF_WHEEL)/python -m pytest --quiet --numprocesses $(JOBS) -m "not slow and not checkout"

# What the paper's section 6 wished for, also on engines that the suite leaves out.
SECTIONS := wall-bounce masse sliding-swerve air-rolls restitution-bounce flight-jump
SECTION_ENGINES := ghostball pymunk pymunk:contact_steps=exact pybullet pybullet:contact_steps=exact paper-discrete \
	paper-continuous mujoco physx:cloth=own dart:cloth=own

# Engines that fail in these shots are drawn as well (status 1).
gallery: engines validate  ## remake the pictures of the README and the documentation
	$(BIN)/ghostball validate $(SECTIONS) $(addprefix -e ,$(SECTION_ENGINES)) --jobs $(JOBS) \
		--out $(OUT)/sections --no-report || test $$? -eq 1
	$(BIN)/python -m benchmarks gallery $(OUT) docs/pictures --sections $(OUT)/sections

peers:  ## other billiards engines, into .venv-peers, for `python -m benchmarks` to measure beside ours
	@test -n "$(PYTHON)" && $(PYTHON) $(FIT) || { \
		echo "error: Python 3.11 or newer is needed, got '$(PYTHON)'" >&2; exit 2; }
	$(PYTHON) -m venv --clear .venv-peers
	.venv-peers/bin/python -m pip install --quiet --disable-pip-version-check \
		--requirement reference_adapters/workers/scripts/requirements.txt
	@# Without what it asks for: that would be a panda3d that is nowhere to be had.
	.venv-peers/bin/python -m pip install --quiet --disable-pip-version-check --no-deps \
		pooltool-billiards==0.6.0

peers-js:  ## engines in JavaScript, into .peers-js, by the lock file of npm; needs Node.js 18 or newer
	@command -v npm >/dev/null || { \
		echo "error: npm is needed, which comes with Node.js 18 or newer (Debian, Ubuntu: apt install npm)" >&2; exit 2; }
	mkdir -p .peers-js
	cp reference_adapters/javascript/driver/package.json reference_adapters/javascript/driver/package-lock.json .peers-js
	npm ci --prefix .peers-js --no-audit --no-fund --loglevel error

clean:  ## remove the environment and the caches; results stay
	rm -rf $(VENV) .venv-peers .peers-js .venv-wheel .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache \
		.coverage .coverage.* htmlcov build
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
