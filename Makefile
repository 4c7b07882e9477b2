# make demo: the example;  make test, make check: what must pass;  make docs: the site;
# see CONTRIBUTING.md.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
DOCS_STAMP := $(VENV)/.docs-installed

# The oldest Python supported makes the lock file, so that the versions in it serve all.
LOCK_PYTHON ?= python3.11
LOCK_VENV   := .venv-lock
# UPGRADE= keeps the versions that are locked, and adds what is missing.
UPGRADE     ?= --upgrade
COMPILE     = CUSTOM_COMPILE_COMMAND="make lock" $(LOCK_VENV)/bin/pip-compile --quiet $(UPGRADE) \
    --strip-extras --no-emit-index-url --no-emit-trusted-host --no-emit-find-links \
    --pip-args='--only-binary :all:'

.PHONY: demo test check docs wheel-test benchmark documentation validation lock clean

demo: $(STAMP)
	$(BIN)/python examples/demo.py

test: $(STAMP)
	$(BIN)/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder --durations=15

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# The site, in docs/_site; a broken link, a warning or a cell that fails is an error.
docs: $(DOCS_STAMP)
	$(BIN)/python -m sphinx -q -W --keep-going -j 2 -b html docs docs/_site
	@echo docs/_site/index.html

# For other Pythons: make wheel-test PYTHONS="python3.12 python3.13"
wheel-test: $(STAMP)
	$(BIN)/python packaging/wheel_test.py $(PYTHONS)

benchmark: $(STAMP)
	$(BIN)/python benchmarks/run.py

# docs/diagnostics.md from the analyses themselves, docs/bibliography.md from the sources.
documentation: $(STAMP)
	$(BIN)/python -m celltrain.contract.documentation > docs/diagnostics.md
	$(BIN)/python -m celltrain.citation.page > docs/bibliography.md

validation: $(STAMP)
	$(BIN)/python validation/run.py

# Renewed when the locked versions or the package's own metadata change.
$(STAMP): requirements.lock pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --only-binary :all: -r requirements.lock
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	touch $@

$(DOCS_STAMP): $(STAMP) docs/requirements.lock
	$(BIN)/python -m pip install --quiet --only-binary :all: -r docs/requirements.lock
	touch $@

lock:
	$(LOCK_PYTHON) -m venv $(LOCK_VENV)
	$(LOCK_VENV)/bin/python -m pip install --quiet 'pip-tools>=7.5'
	$(COMPILE) --extra dev --extra explore --extra simulations --extra studies \
	    --output-file requirements.lock pyproject.toml
	$(COMPILE) --extra docs --constraint requirements.lock \
	    --output-file docs/requirements.lock pyproject.toml

clean:
	rm -rf $(VENV) $(LOCK_VENV) out build dist docs/_site docs/generated docs/jupyter_execute .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find src tests examples benchmarks validation -name __pycache__ -prune -exec rm -rf {} + \
	    2>/dev/null || true
