# Everything happens in $(VENV); nothing is installed outside it.
#   make test PYTHON=python3.13 VENV=.venv-313    another interpreter, beside the first
#   make test WORKERS=0                           one test after another (debuggers, timings)
#   make test ARGS="-k restitution -x"            further arguments for pytest

PYTHON  ?= python3
VENV    ?= .venv
WORKERS ?= 2
ARGS    ?=

BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check
PYTEST := $(BIN)/python -m pytest
NATIVE := CMakeLists.txt $(shell find contact_toolkit/cpp -name '*.cpp' -o -name '*.h')

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help build demo test test-slow bench lint format types sanitize tsan wheel wheel-test \
        clean distclean check-python

help:  ## show this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1|\2/' \
	  | column -t -s '|' 2>/dev/null || grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST)

# --- environment ---------------------------------------------------------------------------------

# A venv that another interpreter made would silently win over PYTHON=.
check-python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "$(PYTHON) is missing or older than 3.11; choose another: make $(MAKECMDGOALS) PYTHON=python3.12" >&2; exit 1; }
	@want=$$($(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])'); \
	  if [ -x $(BIN)/python ]; then \
	    have=$$($(BIN)/python -c 'import sys; print("%d.%d" % sys.version_info[:2])'); \
	    [ "$$want" = "$$have" ] || { echo "$(VENV) holds Python $$have, PYTHON=$(PYTHON) is $$want; add VENV=.venv-$$want" >&2; exit 1; }; \
	  fi

$(BIN)/python: | check-python
	$(PYTHON) -m venv $(VENV)

$(VENV)/.tools: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) install -q -c constraints.txt scikit-build-core nanobind cmake ninja
	@touch $@

$(VENV)/.installed: $(VENV)/.tools $(NATIVE)
	$(PIP) install -q -c constraints.txt --no-build-isolation -e '.[test]'
	@touch $@

# Further extras: the project is installed already, so only what it lacks is fetched.
$(VENV)/.extra-%: $(VENV)/.tools | $(VENV)/.installed
	$(PIP) install -q -c constraints.txt 'contact-toolkit[$*]'
	@touch $@

build: $(VENV)/.installed check-python  ## set up the environment and compile

# --- use -----------------------------------------------------------------------------------------

demo: build  ## drop a doughnut on a cone and print where the playback is
	$(BIN)/contact-toolkit run rock_n_stack --out runs/rock_n_stack

test: build  ## run the tests, all but the slow ones
	$(PYTEST) -n $(WORKERS) --dist loadfile -m 'not slow' $(ARGS)

# pytest's 5: there are none
test-slow: build  ## run the slow tests
	$(PYTEST) -n $(WORKERS) --dist loadfile -m slow $(ARGS) || [ $$? = 5 ]

bench: build $(VENV)/.extra-bench  ## measure against the yardsticks
	$(BIN)/python -m benchmarks --out benchmarks $(ARGS)

# --- checks --------------------------------------------------------------------------------------

CPP_FILES = $$(find contact_toolkit/cpp -name '*.cpp' -o -name '*.h')

lint: build $(VENV)/.extra-dev  ## check style and layers
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/clang-format --dry-run -Werror $(CPP_FILES)
	$(BIN)/lint-imports

format: build $(VENV)/.extra-dev  ## put all sources into the project's format
	$(BIN)/ruff check --fix-only
	$(BIN)/ruff format
	$(BIN)/clang-format -i $(CPP_FILES)

types: build $(VENV)/.extra-dev  ## check types
	cp $$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("platlib"))')/contact_toolkit/_core.pyi contact_toolkit/
	$(BIN)/mypy

# The interpreter is not instrumented, so the sanitizer's library has to be loaded before it; and
# the C++ library with it, because the sanitizer wraps its throw. What uninstrumented libraries
# (numpy's threads) do among themselves is no finding. setarch: some kernels randomise addresses
# more than ThreadSanitizer can bear. -s: a report is the last thing a dying process says, and
# pytest would keep it to itself.
CXX_LIB = $$($(CXX) -print-file-name=$(1).so)
NO_ASLR = $$(setarch -R true 2>/dev/null && echo setarch -R)
define instrumented
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset $(1) -DPython_EXECUTABLE=$(abspath $(BIN)/python)
	PATH="$(abspath $(BIN)):$$PATH" cmake --build --preset $(1)
	CONTACT_TOOLKIT_CORE=$$(ls $(CURDIR)/build/$(1)/_core*.so) PYTHONPATH=$(CURDIR)/tests \
	  LD_PRELOAD="$(call CXX_LIB,$(2)):$(call CXX_LIB,libstdc++)" PYTHONMALLOC=malloc \
	  ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 \
	  TSAN_OPTIONS=halt_on_error=1:ignore_noninstrumented_modules=1 \
	  $(3) $(PYTEST) -s -n $(WORKERS) -p instrumented_core -m '$(4) and not slow' $(ARGS)
endef

sanitize: build  ## run the engine's tests under the address and undefined-behaviour sanitizers
	$(call instrumented,sanitize,libasan,,engine)

tsan: build  ## run the threaded tests under the thread sanitizer
	$(call instrumented,tsan,libtsan,$(NO_ASLR),threads)

wheel: $(VENV)/.extra-dev  ## build the wheel into dist/
	rm -rf dist
	PIP_CONSTRAINT=$(CURDIR)/constraints.txt $(BIN)/python -m build --wheel -C build-dir=build/wheel

# Outside the checkout, so that nothing is picked up from it.
wheel-test: wheel  ## install the wheel in a clean environment elsewhere and run the demo there
	dir=$$(mktemp -d) && trap 'rm -rf "$$dir"' EXIT && \
	$(PYTHON) -m venv "$$dir/venv" && \
	"$$dir/venv/bin/python" -m pip --disable-pip-version-check install -q -c constraints.txt dist/*.whl && \
	cd "$$dir" && venv/bin/contact-toolkit run rock_n_stack --out run

clean:  ## remove what was built
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	rm -f contact_toolkit/_core.pyi $(VENV)/.installed

distclean: clean  ## remove the environment as well
	rm -rf $(VENV)
