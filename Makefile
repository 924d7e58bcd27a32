# make demo [TASK=sorting] [SEED=1]   one whole study session in the simulated cell
# make test                           lint, types, every test
# make bench                          speed, as tables
SHELL := /bin/bash
TASK ?= sorting
SEED ?= 1

.PHONY: demo test bench build lint clean

build:
	@tools/setup

demo: build
	@./mbd run mbd_bringup demo --task $(TASK) --seed $(SEED) $(ARGS)

lint: build
	@.venv/bin/ruff format --check .
	@.venv/bin/ruff check .
	@.venv/bin/mypy

test: build lint
	@tools/browser
	@source ./env.sh && python -m pytest tests $(ARGS)

bench: build
	@source ./env.sh && python -m pytest benchmarks --benchmark-only $(ARGS)

clean:
	rm -rf .venv ros2_ws/build ros2_ws/install ros2_ws/log ros2_ws/build.log
