# `make run` and `make test` need nothing but python3 (3.11 or later) and make.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# every process of the tests compiles the package anew where bytecode is not kept
unexport PYTHONDONTWRITEBYTECODE
WRITES := $(VENV)/.writes

.PHONY: run test tests explore browser check docs benchmarks validation mutants release-check matrix paper clean

run: $(READY)
	$(BIN)/pymdr run examples/ball_on_glass.toml -o out

# types take one core half a minute: the tests begin beside them
test: $(READY)
	$(MAKE) --no-print-directory --jobs=2 check tests

tests: $(READY)
	$(BIN)/python -m pytest -n auto --dist worksteal

# all tests, the long ones too, with random examples drawn anew, as often as one likes
explore: $(READY)
	$(BIN)/python -m pytest -n auto -m "" --hypothesis-profile=explore

# the page of `pymdr explore` in Chromium, whose packages chromium and chromium-driver (or alike) are of the system
browser: $(READY)
	$(BIN)/python -m pip install --quiet --group browser
	PYMDR_BROWSER=1 $(BIN)/python -m pytest -q -s -p no:xdist tests/browser

check: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/mypy

docs: $(WRITES)
	$(BIN)/python -m sphinx -j auto -W --keep-going -q $(SPHINXOPTS) -b html docs docs/_build/html

benchmarks: $(READY)
	$(BIN)/python -m benchmarks

# the tables of docs/validation.md, recomputed: some minutes
validation: $(READY)
	$(BIN)/python -m benchmarks.validation

# small mistakes in the source, and whether a test notices them: hours
mutants: $(READY)
	$(BIN)/python -m pip install --quiet --group mutants
	$(BIN)/python -m pytest -q -n auto -m "" --cov=pymdr --cov-context=test --cov-report=
	$(BIN)/python -m tests.mutants

# the archives of the last commit, built twice, compared, checked, installed and run: two minutes, written into dist
release-check: $(READY)
	$(BIN)/python -m pip install --quiet --group release
	$(BIN)/python -m tests.release archives

# every Python of 3.11 to 3.13 that is here, and the oldest versions of what the package needs: some minutes
matrix: $(READY)
	$(BIN)/python -m pip install --quiet --group release
	$(BIN)/python -m tests.release matrix

# the paper with its citations and figures, written into build
paper: $(READY)
	$(BIN)/python -m pip install --quiet --group paper
	$(BIN)/python -m tests.release paper

$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --group test --editable .
	touch $@

$(WRITES): $(READY)
	$(BIN)/python -m pip install --quiet --group docs
	touch $@

clean:
	rm -rf $(VENV) out build dist
