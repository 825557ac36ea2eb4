# The thin front of Sanatrix: everything a user or a CI machine types. Debian 12.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
BUILD := build/release
SANATRIX := $(BUILD)/apps/sanatrix/sanatrix
JOBS := $(shell nproc)
export SANATRIX_SHARED ?= $(abspath ../shared)
# Small dense blocks: threads of the BLAS only get in the way of the assembly's own.
export OPENBLAS_NUM_THREADS ?= 1

.DEFAULT_GOAL := build
.PHONY: run serve build test bench format tidy clean packages configure

## run: build, then take the built-in patient through every step into out/case
run: build
	@test -f out/phantom/truth/truth.json || $(SANATRIX) phantom out/phantom
	@test -f out/case/case.json || $(SANATRIX) new out/case \
	  --labels out/phantom/labels.nii.gz --plan out/phantom/plan.json
	@$(SANATRIX) run out/case
	@echo "against the phantom's truth:"
	@$(SANATRIX) score out/case out/phantom

## build: install what is missing, then the release build
build: configure
	@cmake --build $(BUILD) -j $(JOBS)

## test: build, then all tests
test: build
	@OMP_NUM_THREADS=1 ctest --test-dir $(BUILD) --output-on-failure --no-tests=error -j $(JOBS)

## bench: kernels, a patient's stages by mesh size (BENCH_SIZES, thousands), solves beside peers
BENCH_SIZES ?= 5,10
bench: build
	@for source in bench/*_bench.cpp; do \
	  name=$$(basename $$source .cpp); \
	  cmake --build $(BUILD) -j $(JOBS) --target $$name && $(BUILD)/bench/$$name; \
	done
	@bench/stages.py --binary $(SANATRIX) --sizes $(BENCH_SIZES)
	@bench/peers.py --binary $(SANATRIX)

configure: packages
	@cmake --preset release > /dev/null

# The one list of dependencies is apt-packages.txt; nothing is asked of apt when all are there.
# A Node.js from elsewhere does as well as Debian's.
packages:
	@node_is_there=$$(command -v node > /dev/null && command -v npm > /dev/null && echo yes || true); \
	missing=$$(sed 's/#.*//' apt-packages.txt | while read -r name; do \
	  [ -n "$$node_is_there" ] && { [ "$$name" = nodejs ] || [ "$$name" = npm ]; } && continue; \
	  [ -z "$$name" ] || dpkg-query -W -f='$${Status}' "$$name" 2>/dev/null \
	    | grep -q 'install ok installed' || echo "$$name"; done); \
	if [ -n "$$missing" ]; then \
	  as_root=$$([ "$$(id -u)" = 0 ] || echo sudo); \
	  echo "installing:" $$missing; \
	  $$as_root apt-get update -q < /dev/null; \
	  $$as_root env DEBIAN_FRONTEND=noninteractive \
	    apt-get install -q -y $$missing < /dev/null; \
	fi

## format: clang-format on all sources
format:
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format-16 -i

## tidy: clang-tidy's checks (.clang-tidy) on all sources, or on TIDY="src/fem/*.cpp ..."
# Without the files that include ITK, whose headers in Debian refuse clang, and without coroutines,
# which clang 16 does not know from GCC's library. omp.h is GCC's own, with an attribute that clang
# refuses with arguments.
TIDY ?= $(shell git ls-files 'src/*.cpp' 'apps/*.cpp' | xargs grep -LE 'include <itk|co_await')
tidy: configure
	@printf '%s\n' $(TIDY) | xargs -P $(JOBS) -n 1 clang-tidy-16 -p $(BUILD) --quiet \
	  --extra-arg=-idirafter$(dir $(shell $(CXX) -print-file-name=include/omp.h)) \
	  '--extra-arg=-D__malloc__(...)='

## serve: build, then the planner in the browser on out/cases
serve: build
	@$(SANATRIX) serve --cases out/cases --open

## clean: remove builds; results in out/ stay
clean:
	rm -rf build
