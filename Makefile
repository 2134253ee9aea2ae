SCALE ?= quick
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: help setup reproduce docs test test-all wheel lint clean

help: ## show this help
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  SCALE=smoke|quick|paper chooses how much of each experiment runs (default: quick)"

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit("Python >= 3.11 is needed; choose one with: make PYTHON=/path/to/python3") if sys.version_info < (3, 11) else None'
	@echo "setting up $(VENV): the dependencies are downloaded and installed, which takes a few minutes"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --progress-bar on --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

setup: $(STAMP) ## create .venv with the pinned dependencies (done by every other target)

reproduce: $(STAMP) ## run every experiment, then leave verdicts, report, figures and recordings in outputs/
	@$(BIN)/repro reproduce scale=$(SCALE)

docs: $(STAMP) ## build the documentation into site/
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "open site/index.html"

lint: $(STAMP) ## ruff (lint and format) and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: $(STAMP) lint ## lint, types and the quick test suite
	$(BIN)/pytest -n 2

test-all: $(STAMP) lint ## the quick suite and the long checks
	$(BIN)/pytest -n 2 -m ''

wheel: $(STAMP) ## build the wheel, install it in a new environment, and fit and record there
	$(BIN)/pytest -n 0 -m slow tests/plugins/test_wheel.py

clean: ## remove the virtual environment (results in outputs/ stay)
	rm -rf $(VENV)
