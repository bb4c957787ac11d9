# Every target sets up what it needs in .venv. PYTHON may name another interpreter of version 3.11 or later.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --disable-pip-version-check
DEMO := $(VENV)/.demo
STAMP := $(VENV)/.stamp

OLDEST := .venv-oldest
BENCH := .venv-bench
# what meets the dependencies most: files, units, drag, fields, one run, sweeps and their stores, figures, programmes, rays
CORE := $(addprefix tests/test_,$(addsuffix .py,scenario files gain hydrodynamics magnetics cli_errors sweep_plans \
    sweep_plots plots robot_krl vision_refraction))

.PHONY: venv demo test test-nightly test-oldest lint docs gallery pictures bench lock clean

venv: $(STAMP)

# what the demo needs: helimag, its dependencies, figures; pip says what it fetches
$(DEMO): requirements/demo.txt requirements/installer.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "helimag needs Python 3.11 or later")'
	@echo "Setting up $(VENV): some 45 packages, 1 GB unpacked; half of that is Warp, which brings its own compilers"
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --require-hashes -r requirements/installer.txt
	$(INSTALL) --require-hashes -r requirements/demo.txt
	$(INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

# and what tests, lint, docs and benchmarks need beside it
$(STAMP): $(DEMO) requirements/all.txt
	@echo "Adding what tests, docs and benchmarks need: 1 GB more"
	$(INSTALL) --require-hashes -r requirements/all.txt
	@touch $@

# the main job: Fig. 3 of the paper, three half-hour runs with figure and verdicts, into out/
demo: $(DEMO)
	$(BIN)/helimag reproduce fig3 -o out

test: $(STAMP) lint
	$(BIN)/python -m pytest

# what takes minutes each: all how-to pages as written
test-nightly: $(STAMP)
	$(BIN)/python -m pytest -m nightly

# the core with the oldest versions that pyproject.toml allows; old releases warn about newer ones beside them
test-oldest: $(OLDEST)/.stamp
	$(OLDEST)/bin/python -m pytest -o filterwarnings= $(CORE)

$(OLDEST)/.stamp: requirements/oldest.txt pyproject.toml
	$(PYTHON) -m venv $(OLDEST)
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/oldest.txt
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(STAMP)
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html

# helimag beside other codes, in an environment of their own; some three minutes
bench: $(BENCH)/.stamp
	$(BENCH)/bin/python benchmarks/peers
	$(BENCH)/bin/python benchmarks/peers/figure.py benchmarks/results/peers.png

$(BENCH)/.stamp: requirements/bench.txt requirements/bench-fortran.txt pyproject.toml
	$(PYTHON) -m venv $(BENCH)
	$(BENCH)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/bench.txt
	$(BENCH)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@$(BENCH)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes \
	    -r requirements/bench-fortran.txt > $(BENCH)/numbalsoda.log 2>&1 || \
	    echo "numbalsoda is left out: it could not be built, mostly for want of a Fortran compiler ($(BENCH)/numbalsoda.log)"
	@touch $@

# every measurement that the documentation cites; hours
measurements: $(STAMP)
	for script in benchmarks/*.py; do echo "== $$script"; $(BIN)/python $$script || exit 1; done

# the pictures of the gallery, by the commands that it shows: look at them before they are committed
gallery: $(STAMP)
	$(BIN)/python docs/_ext/gallery.py docs/_static/gallery

# the pictures of the studio's page in the documentation, from its tests: look at them before they are committed
pictures: $(STAMP)
	HELIMAG_STUDIO_PICTURES=$(CURDIR)/docs/_static $(BIN)/python -m pytest -n 0 tests/test_studio.py

# pins everything again; needs uv. The oldest leave the studio out: what it is made of asks for newer ones, and no test
# with the oldest opens it
lock:
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --quiet \
	    --all-extras --group test --group docs --group build pyproject.toml -o requirements/all.txt
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --quiet \
	    --extra plots --group build -c requirements/all.txt pyproject.toml -o requirements/demo.txt
	uv pip compile --resolution lowest-direct --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	    --quiet --extra plots --extra sweeps --extra cluster --extra robot --extra vision \
	    --group oldest --group build pyproject.toml -o requirements/oldest.txt
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --quiet \
	    --extra plots --extra sweeps --group bench --group build -c requirements/all.txt pyproject.toml \
	    -o requirements/bench.txt
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --quiet \
	    --group installer -o requirements/installer.txt
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --quiet --no-deps \
	    --group bench-fortran -o requirements/bench-fortran.txt

clean:
	rm -rf $(VENV) $(OLDEST) $(BENCH) out docs/_build
