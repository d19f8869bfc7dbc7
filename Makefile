# Every target works on a fresh machine: it makes .venv, installs what constraints.txt pins, and adds missing system
# packages when it may. PYTHON can be set to any Python 3.11.
PYTHON ?= python3.11
BIN := .venv/bin
STAMP := .venv/.installed
# MuJoCo's USD reader brings another OpenUSD than ours, so it lives in an environment of its own; tests call it.
MUJOCO_USD := .venv-mujoco-usd
MUJOCO_USD_STAMP := $(MUJOCO_USD)/.installed
# PyTorch and LeRobot's library for the tests that call them: other versions of NumPy and packages than ours.
TORCH := .venv-torch
TORCH_STAMP := $(TORCH)/.installed
DEMO_OUT ?= demo_out
FUZZ ?=
GAP_OUT ?= gap_suite_out
GAP2_OUT ?= gap_suite_2_out
GAP2_START ?= 1000

PYTEST := $(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder
# Top-level folders with Python files that differ from the last commit: what `make quick` checks the types of.
CHANGED = $(shell git status --porcelain -- '*.py' | sed 's/.* //' | grep / | cut -d/ -f1 | sort -u)

.PHONY: demo quick test test-long peers check lint types layers bench fuzz gap-suite gap-suite-2 docs clean system

demo: $(STAMP)
	$(BIN)/mana demo --out $(DEMO_OUT)

# An answer in under two minutes: style, layers, types of what changed, and the files of tests that take under 2 s.
quick: lint layers
	$(if $(CHANGED),$(BIN)/pyright $(CHANGED))
	$(PYTEST) --quick

# Style, types, layers, then all tests but those marked `long`; tests of outside peers where `make peers` installed them.
test: check
	$(PYTEST)

test-long: $(STAMP) peers
	$(PYTEST) -m long

peers: $(MUJOCO_USD_STAMP) $(TORCH_STAMP)
	$(BIN)/mana setup blender
	@sh tools/chromium.sh

check: lint types layers

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/pyright

layers: $(STAMP)
	$(BIN)/lint-imports

bench: $(STAMP)
	$(BIN)/python -m benchmarks.assets.ingest

# 20 real files x 200 mutations of each format; FUZZ="--format urdf --mutations 20" and the like for less.
fuzz: $(STAMP)
	$(BIN)/python -m tests.suites.fuzz.run $(FUZZ)

# About 500 cases; stops and goes on where it stopped. Records in GAP_OUT, one JSON per case.
gap-suite: $(STAMP)
	$(BIN)/python -m tests.suites.gap.run --resume $(GAP_OUT)

# Cases of suite 2 from number GAP2_START; what ran is not run again.
gap-suite-2: $(STAMP)
	$(BIN)/python -m tests.suites.gap2.run --start $(GAP2_START) --n 300 --resume $(GAP2_OUT)

# All generated pages: diagnostics, gate rules, effects; tests/cli/docs compares them with the tree.
docs: $(STAMP)
	$(BIN)/python -m cli.docs

system:
	@sh tools/system-packages.sh

$(STAMP): pyproject.toml constraints.txt tools/system-packages.sh
	@sh tools/system-packages.sh
	@command -v $(PYTHON) >/dev/null || { echo "Python 3.11 is needed: install it or set PYTHON=/path/to/python3.11"; exit 2; }
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev]"
	touch $(STAMP)

$(MUJOCO_USD_STAMP): tools/mujoco-usd-constraints.txt | $(STAMP)
	test -x $(MUJOCO_USD)/bin/python || $(BIN)/python -m venv $(MUJOCO_USD)
	$(MUJOCO_USD)/bin/python -m pip install --quiet --disable-pip-version-check -c $< mujoco-usd
	touch $@

$(TORCH_STAMP): tools/torch-environment.sh tools/torch-requirements.txt tools/lerobot-requirements.txt | $(STAMP)
	@sh $< $(BIN)/python $(TORCH)
	touch $@

clean:
	rm -rf .venv $(MUJOCO_USD) $(TORCH) $(DEMO_OUT)
