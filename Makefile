# Lights and Camera.  `make dock` runs a session, `make test` passes the tests; both set up what is missing.

PYTHON ?= python3
export PYTHON
VENV    = .venv/bin/python
PROLOG  = $(shell grep -l '^:- module' main.pl bridge/prolog/*.pl domain/*.pl domain/reasoning/*.pl indigolog/*.pl indigolog/*/*.pl session/*.pl | xargs grep -L '^:- initialization')
SOURCES = $(shell find bridge geometry numerics stack vision_server image_server report -name '*.py')

.PHONY: dock test test-v4l2 bench setup check clean help
.DEFAULT_GOAL := help

help:
	@echo "make dock    run a session on the simulator (options: make dock ARGS='--seed 7')"
	@echo "make test    run every test"
	@echo "make test-v4l2  the camera against a real kernel driver, in a guest (a few minutes)"
	@echo "make bench   measure; one JSON object a line"
	@echo "make check   ruff, mypy, and Prolog loading without warnings"
	@echo "make setup   what the others do first"

setup: system .venv/.installed bridge/prolog/zmq4pl.so .venv/.compiled .venv/.prolog

.PHONY: system
system:
	@setup/system-packages

.venv/.installed: pyproject.toml | system
	@setup/virtual-environment
	@touch $@

bridge/prolog/zmq4pl.so: $(wildcard bridge/prolog/*.c bridge/prolog/*.h) | system
	@swipl-ld -shared -O2 -Wall -o $@ $(filter %.c,$^) -lzmq

.venv/.compiled: .venv/.installed $(SOURCES)
	@echo "setup: compiling modules and numeric kernels"
	@$(VENV) -m compileall -q bridge geometry numerics stack vision_server image_server report
	@$(VENV) -m vision_server warm
	@$(VENV) -m image_server warm
	@touch $@

# A session would wait for its sources to be read. A warning in one of them ends this.
.venv/.prolog: .venv/.installed bridge/prolog/zmq4pl.so $(PROLOG)
	@swipl --on-warning=status --on-error=status -t halt \
	  -g "current_prolog_flag(argv, [_|Files]), forall(member(File, Files), qcompile(File))" -- $(PROLOG)
	@touch $@

dock: setup
	@swipl main.pl $(ARGS)

test: setup check
	swipl -g main tests/run.pl
	$(VENV) -m pytest

test-v4l2: setup
	@setup/test-v4l2

check: setup
	$(VENV) -m ruff check .
	$(VENV) -m mypy
	swipl -g "use_module(tests/check), check_loading, halt" -t 'halt(1)'

bench: setup
	@$(VENV) -m benchmarks

clean:
	rm -rf .venv bridge/prolog/zmq4pl.so */*.qlf */*/*.qlf runs build *.egg-info
