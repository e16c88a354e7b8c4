# Lights and Camera.  `make dock` runs a session, `make test` passes the tests; both set up what is missing.

PYTHON ?= python3
export PYTHON
# What is compiled stays, whatever the shell says: every start of Python would read its sources again.
unexport PYTHONDONTWRITEBYTECODE
VENV    = .venv/bin/python
# A file goes to one worker, whose tests share what it prepares; in the order of folders, so that short files come last.
PYTEST  = $(VENV) -m pytest --dist loadfile --no-loadscope-reorder
# What a session loads.
PROLOG  = $(shell find main.pl bridge domain indigolog session -name '*.pl' ! -path 'domain/testing/*' | \
            xargs grep -l '^:- module' | xargs grep -L '^:- initialization')
ROOMS   = bridge experiments geometry numerics session stack vision_server image_server report
SOURCES = $(shell find $(ROOMS) -name '*.py')

.PHONY: dock test test-quick coverage api docs test-v4l2 bench setup check clean help
.DEFAULT_GOAL := help

help:
	@echo "make dock    run a session on the simulator (make dock ARGS='--seed 7')"
	@echo "make test    run every test; test-quick: without the slow ones,"
	@echo "             test-v4l2: the camera against a real kernel driver, in a guest,"
	@echo "             coverage: which lines the Python tests run"
	@echo "make bench   measure; one JSON object a line"
	@echo "make api     pages from docstrings and PlDoc, into build/api"
	@echo "make docs    the documentation as a site, into build/site"
	@echo "make check   ruff, mypy, and Prolog loading without warnings"
	@echo "make setup   what the others do first"
	@echo "make clean   remove all that these have made; the runs stay"

setup: system .venv/.installed bridge/prolog/zmq4pl.so .venv/.compiled .venv/.prolog

.PHONY: system
system:
	@setup/system-packages

.venv/.installed: pyproject.toml | system
	@setup/virtual-environment
	@touch $@

bridge/prolog/zmq4pl.so: $(wildcard bridge/prolog/*.c bridge/prolog/*.h) | system
	@$(PYTHON) bridge/foreign.py

.venv/.compiled: .venv/.installed $(SOURCES)
	@echo "setup: compiling modules and numeric kernels"
	@$(VENV) -m compileall -q $(ROOMS)
	@$(VENV) -m vision_server warm
	@$(VENV) -m image_server warm
	@touch $@

# A session would wait for its sources to be read. A warning in one of them ends this.
.venv/.prolog: .venv/.installed bridge/prolog/zmq4pl.so $(PROLOG)
	@rm -f main.qlf; find bridge domain indigolog session -name "*.qlf" -delete
	@swipl --on-warning=status --on-error=status -t halt \
	  -g "current_prolog_flag(argv, Files), forall(member(File, Files), qcompile(File))" -- $(PROLOG)
	@touch $@

dock: setup
	@swipl main.pl $(ARGS)

# Three files of Python tests at a time, as some wait for what they have killed or for who does not answer, and beside them
# the Prolog tests and the checks, each of one process: their words come when the Python tests are done.
test: setup
	@echo "test: checks (ruff, mypy), Prolog (plunit) and Python (pytest, all), beside each other"
	@setup/beside "make --no-print-directory check" "swipl -g main tests/run.pl" "$(PYTEST) -n 3"

test-quick: setup
	@echo "test-quick: Prolog (plunit) and Python (pytest, without those marked slow), beside each other"
	@setup/beside "TESTS=quick swipl -g main tests/run.pl" "$(PYTEST) -n 3 -m 'not slow'"

coverage: setup
	@echo "coverage: Python tests, and which lines of the rooms they run (build/coverage)"
	@mkdir -p build
	$(PYTEST) -n 2 --cov --cov-report=term --cov-report=html:build/coverage

api: setup
	@echo "api: pages from docstrings (pdoc) and from PlDoc, into build/api"
	@$(VENV) -c 'import pdoc, zensical' 2>/dev/null || $(VENV) -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	@$(VENV) setup/python-pages.py build/api/python $(ROOMS)
	@swipl setup/prolog-pages.pl build/api/prolog

# A warning ends it: a link or an anchor that leads nowhere.
docs: api
	@echo "docs: the site, into build/site"
	@$(VENV) -m zensical build --clean --strict
	@cp -r build/api build/site/api

test-v4l2: setup
	@setup/test-v4l2

check: setup
	$(VENV) -m ruff check .
	$(VENV) -m ruff format --check .
	$(VENV) -m mypy
	swipl -g "use_module(tests/check), check_loading, halt" -t 'halt(1)'

bench: setup
	@$(VENV) -m benchmarks

# What sessions have left in runs/ is the user's.
clean:
	rm -rf .venv bridge/prolog/zmq4pl.so */*.qlf */*/*.qlf build *.egg-info
