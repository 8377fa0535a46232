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
.PHONY: help build demo test test-slow test-models bench bench-steps docs lint format types debug clang plain arm sanitize tsan \
        wheel wheels wheel-test clean distclean check-python

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
	@ln -sf "$$(ls -t build/*/compile_commands.json | head -n 1)" compile_commands.json
	@touch $@

# Further extras: the project is installed already, so only what it lacks is fetched.
$(VENV)/.extra-%: $(VENV)/.tools | $(VENV)/.installed
	$(PIP) install -q -c constraints.txt 'contact-toolkit[$*]'
	@touch $@

build: $(VENV)/.installed check-python  ## set up the environment and compile

# --- use -----------------------------------------------------------------------------------------

demo: build  ## drop a doughnut on a cone and print where the playback is
	$(BIN)/contact-toolkit run rock_n_stack --out runs/rock_n_stack --force
	@echo
	@echo "Next:"
	@echo "  $(BIN)/contact-toolkit replay runs/rock_n_stack      the playback, in the browser"
	@echo "  ls runs/rock_n_stack/figures                        its figures"
	@echo "  $(BIN)/contact-toolkit list                          the other scenarios"
	@echo "  $(BIN)/contact-toolkit play dropped_robot            one of them live, with sliders"
	@echo "  $(BIN)/contact-toolkit compare dropped_robot         the same under Drake's own contact"
	@echo "  $(BIN)/contact-toolkit schema                        what a scenario file may hold"
	@echo "  make $(VENV)/.extra-notebooks && $(BIN)/jupyter lab notebooks"

test: build  ## run the tests, all but the slow ones
	$(PYTEST) -n $(WORKERS) --dist loadfile -m 'not slow' $(ARGS)

# pytest's 5: there are none
test-slow: build  ## run the slow tests
	$(PYTEST) -n $(WORKERS) --dist loadfile -m slow $(ARGS) || [ $$? = 5 ]

test-models: build $(VENV)/.extra-models  ## let model files of others fall on a table, and act in scenes
	$(PYTEST) -n $(WORKERS) -m slow tests/systems/test_model_zoo.py tests/systems/test_scenes.py $(ARGS)

bench: build $(VENV)/.extra-bench  ## measure against the yardsticks
	$(BIN)/python -m benchmarks --out benchmarks $(ARGS)

bench-steps: build $(VENV)/.extra-models  ## measure discrete plants beside Drake's own contact, and springs a case
	$(BIN)/python -m benchmarks.discrete_steps --out benchmarks/DISCRETE_STEPS.md
	$(BIN)/python -m benchmarks.springs --out benchmarks/SPRINGS.md

# The pages and what they show from elsewhere, in one tree, with the links between them.
docs: build $(VENV)/.extra-docs  ## execute the notebooks and make the site, build/site/index.html
	rm -rf build/docs && mkdir -p build/docs
	cp -R README.md CONTRIBUTING.md CHANGELOG.md docs build/docs/
	cp -R notebooks benchmarks build/docs/docs/
	cp --parents systems/README.md contact_toolkit/cpp/README.md \
	  scenarios/gallery/*.png build/docs/docs/
	$(BIN)/python -m sphinx -W --keep-going -q -b html $(ARGS) build/docs/docs build/site
	@echo "build/site/index.html"

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
define preset
	PATH="$(abspath $(BIN)):$$PATH" cmake --preset $(1) -DPython_EXECUTABLE=$(abspath $(BIN)/python)
	PATH="$(abspath $(BIN)):$$PATH" cmake --build --preset $(1) $(addprefix --target ,$(2))
endef
# The engine's tests on the core of a preset: all of them, or those in some folders.
define on_preset
	$(call preset,$(1))
	CONTACT_TOOLKIT_CORE=$$(ls $(CURDIR)/build/$(1)/_core*.so) PYTHONPATH=$(CURDIR)/tests/support \
	  $(PYTEST) -n $(WORKERS) -p instrumented_core -m 'engine and not slow' $(2) $(ARGS)
endef
define instrumented
	$(call preset,$(1))
	CONTACT_TOOLKIT_CORE=$$(ls $(CURDIR)/build/$(1)/_core*.so) PYTHONPATH=$(CURDIR)/tests/support \
	  LD_PRELOAD="$(call CXX_LIB,$(2)):$(call CXX_LIB,libstdc++)" PYTHONMALLOC=malloc \
	  ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 \
	  TSAN_OPTIONS=halt_on_error=1:ignore_noninstrumented_modules=1 \
	  $(3) $(PYTEST) -s -n $(WORKERS) -p instrumented_core -m '$(4) and not slow' $(ARGS)
endef

debug: build  ## build the core for a debugger and run the engine's tests on it (try WORKERS=0)
	$(call on_preset,debug)

clang: build  ## build the core with clang and run the engine's tests on it
	$(call on_preset,clang)

plain: build  ## build the core without AVX and run the queries' tests on it
	$(call on_preset,plain,tests/query tests/shapes)

# Needs Debian's g++-aarch64-linux-gnu and qemu-user.
arm: build  ## build the core for AArch64 (NEON) and compare its answers with this processor's
	$(call preset,arm)
	$(call preset,plain,portable_core)
	qemu-aarch64 build/arm/portable_core > build/arm/answers.txt
	build/plain/portable_core | diff - build/arm/answers.txt && echo "the same bits: $$(wc -l < build/arm/answers.txt) lines"

sanitize: build  ## run the engine's tests under the address and undefined-behaviour sanitizers
	$(call instrumented,sanitize,libasan,,engine)

tsan: build  ## run the threaded tests under the thread sanitizer
	$(call instrumented,tsan,libtsan,$(NO_ASLR),threads)

# By way of the sdist, so that what is not in it is missed; the tag by what auditwheel finds in the
# wheel: the oldest Linux it runs on.
wheel: $(VENV)/.extra-dev  ## build the sdist, and from it this machine's wheel, into dist/
	rm -rf dist build/dist
	PIP_CONSTRAINT=$(CURDIR)/constraints.txt $(BIN)/python -m build -o build/dist
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/auditwheel repair -w dist build/dist/*.whl
	mv build/dist/*.tar.gz dist/

wheels: $(VENV)/.extra-dev  ## build the wheels of all Pythons into dist/; needs Docker
	$(BIN)/cibuildwheel --output-dir dist

# Outside the checkout, so that nothing is picked up from it.
wheel-test: wheel  ## install the wheel in a clean environment elsewhere and try it there
	.ci/try_wheel $(PYTHON) dist/*.whl

clean:  ## remove what was built
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	rm -f contact_toolkit/_core.pyi compile_commands.json $(VENV)/.installed

distclean: clean  ## remove the environment as well
	rm -rf $(VENV)
