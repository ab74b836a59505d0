# Needs nothing but Python 3.11 to 3.14 with venv and pip; every other tool is put into .venv from requirements.lock.

SCENARIO ?= scenarios/demo/scenario.yaml
SEEDS    ?= 1 6
CASES    ?= 10000
SEED     ?= 1
LOCKED   := import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))
USABLE   := import venv, ensurepip; $(LOCKED)
PYTHON   ?= $(shell for p in python3.11 python3 python3.14 python3.13 python3.12; do \
	$$p -c '$(USABLE)' 2>/dev/null && echo $$p && break; done)
PYTEST   ?= -n 2 --dist worksteal --durations=15

BIN   := .venv/bin
READY := .venv/ready

# The engines are single-threaded; threads inside linear algebra would only take the cores from the other tests.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1
export PIP_DISABLE_PIP_VERSION_CHECK ?= 1

.DEFAULT_GOAL := help

.PHONY: help
help:  ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /\1	/p' Makefile | expand -t 10

.PHONY: demo
demo: $(READY)  ## run the bundled scenario in every engine and write its report page
	$(BIN)/realitygap run $(SCENARIO)

.PHONY: test
test: $(READY)  ## run the tests
	$(BIN)/pytest $(PYTEST)

.PHONY: lint
lint: $(READY)  ## ruff: rules and format
	$(BIN)/ruff check
	$(BIN)/ruff format --check

.PHONY: types
types: $(READY)  ## mypy, strict
	$(BIN)/mypy

.PHONY: check
check: lint types test  ## lint, types and tests

.PHONY: blind
blind: $(READY)  ## diagnose the whole suite of planted truths, one open and one sealed seed (many hours)
	$(BIN)/python tests/planted/run.py $(SEEDS:%=--seed %) --reference results/reference

.PHONY: fuzz
fuzz: $(READY)  ## 10,000 files of every kind that are not what they should be (CASES, SEED)
	PYTHONPATH=tests:engines:harness $(BIN)/python -m fuzz.run --cases $(CASES) --seed $(SEED) --keep results/runs/fuzz

.PHONY: bench
bench: $(READY)  ## measure what the harness costs over bare loops and beside mujoco.rollout, and a diagnosis by phase
	$(BIN)/python tests/bench_overhead.py
	$(BIN)/python tests/bench_threads.py
	$(BIN)/python tests/bench_diagnosis.py

.PHONY: reference
reference: $(READY)  ## write the reference of all files that people write: scenarios/README.md, JSON Schemas
	$(BIN)/python -m realitygap.cli.reference

.PHONY: lock
lock: $(READY)  ## write requirements.lock anew from pyproject.toml; keeps versions that still fit
	$(BIN)/uv pip compile pyproject.toml --all-extras --universal --python-version 3.11 --generate-hashes \
		--no-emit-index-url --no-annotate --custom-compile-command 'make lock' --quiet -o requirements.lock

.PHONY: clean
clean:  ## remove the environment, caches and runs
	rm -rf .venv build dist results/runs .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find engines harness tests -name __pycache__ -prune -exec rm -rf {} +

# Brought up to date when the lock or pyproject.toml changes. An environment that another tool made without pip gets pip;
# one whose Python is gone is made anew.
$(READY): requirements.lock pyproject.toml
	@test -n "$(PYTHON)" && $(PYTHON) -c '$(USABLE)' 2>/dev/null || { echo "found no Python of 3.11 to 3.14, which the lock holds, with venv and pip;" \
		"install one (Debian: python3 and python3-venv) or name it: make PYTHON=python3.12"; exit 1; }
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(BIN)/python -m ensurepip >/dev/null 2>&1 \
		|| $(PYTHON) -m venv --clear .venv
	@echo "installing into .venv (about 2.5 GB, the first time takes some minutes)"
	@$(BIN)/python -c '$(LOCKED)' || { echo ".venv has a Python that the lock does not hold (3.11 to 3.14):" \
		"remove it with make clean"; exit 1; }
	@$(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	@touch $@
