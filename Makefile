# make demo [TASK=sorting] [SEED=1]   one complete study session in the simulated cell
# make session [TASK=] [PARTICIPANT=]  the same, led by you on the console's page; every option by ARGS="..."
# make check                          before a commit: format, lint, types, import contract, unit tests
# make test                           everything make check does, and every other test
# make format                         mend what ruff can mend
# make bench                          speed, as tables
# make docs                           the documentation as a site, in out/site
# make clean                          forget .venv and the build
SHELL := /bin/bash
TASK ?= sorting
SEED ?= 1
PARTICIPANT ?= p01
# Node and session tests wait more than they compute: more workers than cores.
WORKERS ?= 4
PYTEST = source ./env.sh && python -m pytest

.PHONY: demo session check test format lint types unit bench docs build clean

build:
	@tools/setup

demo: build
	@./mbd run mbd_bringup demo --task $(TASK) --seed $(SEED) $(ARGS)

session: build
	@./mbd run mbd_bringup session --task $(TASK) --participant $(PARTICIPANT) --console $(ARGS)

format: build
	@.venv/bin/ruff format .
	@.venv/bin/ruff check --fix .

lint: build
	@.venv/bin/ruff format --check .
	@.venv/bin/ruff check .
	@source ./env.sh && lint-imports --no-cache --no-logo

types: build
	@source ./env.sh && tools/message_stubs ros2_ws/build/typings && mypy

unit: build
	@$(PYTEST) tests -m unit -n $(shell nproc) --dist worksteal $(ARGS)

check: build
	@$(MAKE) --no-print-directory -k -j2 --output-sync=target lint types unit

test: build lint types
	@tools/browser
	@$(PYTEST) tests -n $(WORKERS) --dist loadgroup --durations=20 $(ARGS)

bench: build
	@$(PYTEST) benchmarks --benchmark-only $(ARGS)

docs: build
	@tools/docs

clean:
	rm -rf .venv ros2_ws/build ros2_ws/install ros2_ws/log ros2_ws/build.log
