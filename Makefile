# One task runner. Everything is installed into .venv, from the lock files.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
# Tests that share what is made for their file stay together until a worker runs dry.
PARALLEL := --numprocesses=auto --dist=worksteal
# The core is compiled by a rule of its own, so not here.
EDITABLE = ELASTOCAL_CORE=numpy $(PIP) install --no-deps --no-build-isolation -e .
SANITIZED := build/sanitized
STRICT := -g -O0 -fsanitize=address,undefined -fno-sanitize-recover=all
STRICT += -Wall -Wextra -Wshadow -Wconversion -Wvla -Wstrict-prototypes -Werror

# One thread: the matrices are small, and several threads only get in each other's way.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

.PHONY: demo test test-full check coverage pythons bench mutate docs core sanitize build lock clean

demo: $(VENV)/.run                 ## plan the KUKA KR 270 campaign and write a report
	$(BIN)/elastocal demo demo
	@echo "open demo/report.html"

test: $(VENV)/.dev                 ## all tests, on the cores there are
	$(BIN)/python -m pytest $(PARALLEL)

test-full: $(VENV)/.dev            ## all tests with ten seeds where one is the default, and mutants; then in NumPy
	ELASTOCAL_FULL=1 $(BIN)/python -m pytest $(PARALLEL)
	ELASTOCAL_CORE=numpy $(BIN)/python -m pytest $(PARALLEL)

coverage: $(VENV)/.dev             ## which lines and branches no test runs
	$(BIN)/python -m pytest $(PARALLEL) --cov --cov-report=term:skip-covered --cov-report=html

pythons:                           ## all tests on every interpreter found
	@for version in 3.11 3.12 3.13 3.14; do \
	    for python in python$$version $${PYENV_ROOT:-$$HOME/.pyenv}/versions/$$version.*/bin/python; do \
	        "$$python" -c "" 2>/dev/null || continue; \
	        echo "Python $$version: $$python"; \
	        $(MAKE) test VENV=.venv-$$version PYTHON="$$python" || exit 1; \
	        continue 2; \
	    done; \
	    echo "Python $$version: not found, not tested"; \
	done

check: $(VENV)/.dev                ## format, lint, types, warnings of the C compiler if there is one
	$(BIN)/ruff format --check src tests benchmarks examples hatch_build.py
	$(BIN)/ruff check src tests benchmarks examples hatch_build.py
	$(BIN)/mypy
	CFLAGS="-Wall -Wextra -Werror" $(BIN)/python hatch_build.py build/checked || test $$? = 2

bench: $(VENV)/.dev                ## timings against other ways to do it
	$(BIN)/python benchmarks/races.py

mutate: $(VENV)/.dev               ## small faults in the core: would the tests notice?
	$(BIN)/python benchmarks/mutate.py

docs: $(VENV)/.dev                 ## the examples in the documentation, run
	$(BIN)/python -m pytest tests/test_docs.py

core: | $(VENV)/bin/python         ## compile the C code; the other targets do when it has changed
	@rm -f build/.core && mkdir -p build
	$(BIN)/python hatch_build.py && touch build/.core

sanitize: $(VENV)/.dev             ## tests of the core, where C code that reads astray is an error
	rm -rf $(SANITIZED) && mkdir -p $(SANITIZED) && cp -r src/elastocal $(SANITIZED)
	CFLAGS="$(STRICT)" $(BIN)/python hatch_build.py $(SANITIZED)/elastocal/core
	watched="env LD_PRELOAD=$$($${CC:-cc} -print-file-name=libasan.so) ASAN_OPTIONS=detect_leaks=0 \
	    PYTHONPATH=$(SANITIZED) $(BIN)/python"; \
	levels=$$($$watched -c "from elastocal.core.library import levels; print(*levels())"); \
	for level in $${levels:?no library}; do \
	    ELASTOCAL_CORE=$$level $$watched -m pytest tests/core tests/proof/test_box_bounds.py || exit 1; \
	done

build: $(VENV)/.dev                ## wheel
	$(BIN)/python -m pip wheel --no-deps --no-build-isolation --wheel-dir dist .

lock: pyproject.toml               ## renew the lock files (needs uv)
	uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	    --no-annotate --no-header --extra build pyproject.toml -o requirements.lock
	uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	    --no-annotate --no-header --extra build --extra dev pyproject.toml -o requirements-dev.lock

clean:
	rm -rf .venv .venv-* dist build demo htmlcov .coverage .mypy_cache .ruff_cache .pytest_cache
	rm -f src/elastocal/core/libcore.*

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

# Without a compiler NumPy does the work: that is said, and looked at again next time.
build/.core: hatch_build.py $(wildcard src/elastocal/core/source/*) | $(VENV)/bin/python
	@mkdir -p build
	$(BIN)/python hatch_build.py && touch $@ || true

$(VENV)/.run: requirements.lock pyproject.toml | $(VENV)/bin/python build/.core
	$(PIP) install --require-hashes -r requirements.lock
	$(EDITABLE)
	touch $@

$(VENV)/.dev: requirements-dev.lock pyproject.toml | $(VENV)/bin/python build/.core
	$(PIP) install --require-hashes -r requirements-dev.lock
	$(EDITABLE)
	touch $@ $(VENV)/.run
