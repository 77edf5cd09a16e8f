# Two commands do the work on a fresh machine: `make demo` and `make test`. `make help` lists all.

CARGO       ?= $(shell command -v cargo || echo "$${CARGO_HOME:-$$HOME/.cargo}/bin/cargo")
CARGO_FLAGS ?=
CC          ?= cc
CFLAGS      ?= -O2

DESTDIR    ?=
PREFIX     ?= /usr/local
LIBDIR     ?= $(PREFIX)/lib
INCLUDEDIR ?= $(PREFIX)/include

# One profile for everything: planning is slow without optimisation, and a second profile would build the physics
# engine a second time.
# `make build FEATURES=cli,bullet` adds the 3D engine, which needs Bullet (scripts/setup.sh --test installs it).
FEATURES ?= cli
PROFILE  := --release --features $(FEATURES) $(CARGO_FLAGS)
TARGET  := $(or $(CARGO_TARGET_DIR),target)
BUILD   := $(TARGET)/release
OUT     := out
JOSTLE  := $(BUILD)/jostle
# The scene that the demo plans in, a disc between two notched blocks, and the limit of the decision.
DEMO_SCENE ?= --count 1 --seed 71 --bodies 4..6
DEMO_PLAN ?= --iterations 400

# What the static library needs where it has the 3D engine.
BULLET := $(if $(findstring bullet,$(FEATURES)),-lBulletDynamics-float64 -lBulletCollision-float64 \
                                                -lLinearMath-float64 -lstdc++)

# Of `make bench`: generated problems, trials of each, seconds a decision.
BENCH_PROBLEMS ?= 20
BENCH_TRIALS   ?= 3
BENCH_SECONDS  ?= 1

HEADERS := $(wildcard include/jostle/*.h include/jostle/*.hpp)
WARN    := -Wall -Wextra -Werror -pedantic

# What `make test` runs, with these features, in this order.
TEST_FEATURES ?= cli,bullet
CHECKS := format lint build-tests test-rust test-headers test-consumer

# Of `make models`: Python with torch (bindings/python/README.md), where data and checkpoints go, minutes of each
# training, how much data, most samples of a judgement, and where the models go. `make models MINUTES=0.2 COUNT=2000
# INTO=out/models` shows in minutes that the path works.
PYTHON  ?= python3
DATA    ?= $(OUT)/training
MINUTES ?= 30
COUNT   ?= 100000
SAMPLES ?=
INTO    ?= models
MODELS  ?= dipn gc gn ppn segmentation
# Options of `make more-loop`, such as --rounds 5.
MORE_LOOP ?=

.PHONY: help setup setup-test build demo test build-tests test-rust test-headers test-consumer test-tract lint format bench \
        results models more-loop test-training install uninstall clean

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1|\2/p' $(MAKEFILE_LIST) | awk -F'|' '{ printf "%-22s %s\n", $$1, $$2 }'

setup:
	@scripts/setup.sh

setup-test:
	@scripts/setup.sh --test

build: setup ## the library (shared and static) and the command-line tool, in target/release
	$(CARGO) build $(PROFILE)

demo: build ## plan in C: push a target free and grasp it; then a picture of a plan of two pushes and a grasp
	@mkdir -p $(OUT)
	$(CC) -std=c11 $(CFLAGS) $(WARN) -Iinclude examples_c/retrieve.c -o $(OUT)/retrieve \
	    $(BUILD)/libjostle.a $(BULLET) -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc
	$(OUT)/retrieve
	@rm -rf $(OUT)/demo-scenes
	$(JOSTLE) generate $(OUT)/demo-scenes $(DEMO_SCENE)
	$(JOSTLE) plan $(OUT)/demo-scenes/*.json $(DEMO_PLAN) --svg $(OUT)/demo.svg
	@printf '%s\n' '' 'The picture of the plan lies in $(OUT)/demo.svg. Where to go next:' \
	    '  the first program      README.md, "In C" and "In Rust"' \
	    '  closed loop, in C      examples_c/retrieve.c, which ran above; controller.cpp is the same in C++' \
	    '  a scene of your own    docs/scene-format.md; the one above is $(OUT)/demo-scenes/*.json' \
	    '  the tool               $(JOSTLE) help, docs/cli.md' \
	    '  which planner          docs/planners.md; rearranging: docs/rearrangement.md; clearing: docs/clearing.md'

test: setup-test ## every check
	@set -e; times=; for check in $(CHECKS); do \
	    start=$$(date +%s); \
	    $(MAKE) --no-print-directory FEATURES=$(TEST_FEATURES) $$check; \
	    times="$$times$$(printf '  %-14s %4d s' $$check $$(($$(date +%s) - start)))\n"; \
	done; printf "make test: all checks passed\n$$times"

build-tests:
	$(CARGO) test $(PROFILE) --no-run

test-rust: ## unit, integration and documentation tests
	$(CARGO) test $(PROFILE)

test-headers: ## each header on its own and the README's program, as strict C11 and C++17
	@set -e; for header in $(HEADERS); do \
	    case $$header in \
	        *.h) echo "$$header: C11"; $(CC) -std=c11 $(WARN) -Iinclude -fsyntax-only -x c $$header ;; \
	    esac; \
	    echo "$$header: C++17"; $(CXX) -std=c++17 $(WARN) -Iinclude -fsyntax-only -x c++ $$header; \
	done
	@echo "README.md: the C program"
	@sed -n '/^```c$$/,/^```$$/{/^```/!p;}' README.md | $(CC) -std=c11 $(WARN) -Iinclude -fsyntax-only -x c -

test-consumer: build ## programs outside of the repository build against the installed library
	tests/consumer/run.sh

test-tract: setup-test ## every network of the repository on the embedded backend and on ONNX Runtime (a long build)
	$(CARGO) test --release --features tract --test tract

lint:
	$(CARGO) clippy $(PROFILE) --all-targets -- -D warnings

format:
	$(CARGO) fmt --check

bench: build ## figures that need no data from outside (docs/benchmarks.md), into out/*.json
	@mkdir -p $(OUT)
	$(JOSTLE) bench push --json $(OUT)/bench-push.json
	$(JOSTLE) bench search --json $(OUT)/bench-search.json
	$(JOSTLE) run generated:$(BENCH_PROBLEMS) --planner pmbs --seconds $(BENCH_SECONDS) --trials $(BENCH_TRIALS) \
	    --json $(OUT)/generated-pmbs.json
	$(JOSTLE) run generated:$(BENCH_PROBLEMS) --planner mcts --seconds $(BENCH_SECONDS) --trials $(BENCH_TRIALS) \
	    --json $(OUT)/generated-mcts.json
	@echo "The reports lie in $(OUT)/"

# RESULTS_FLAGS=--dry-run lists what it would do; interrupted, it goes on where it ended (docs/benchmarks.md).
results: setup-test ## every experiment of bench/results.toml into RESULTS.md and its pictures (under an hour on two cores)
	@$(MAKE) --no-print-directory FEATURES=cli,bullet build
	$(JOSTLE) results -o RESULTS.md $(RESULTS_FLAGS)

test-training: ## the training package: ten steps, export and parity of every network (needs torch)
	@if $(PYTHON) -c 'import torch, onnx, onnxruntime, safetensors, shapely' 2>/dev/null; then \
	    cd bindings/python && $(PYTHON) -m unittest discover tests; \
	else echo "test-training: skipped, $(PYTHON) has no torch, onnx, onnxruntime, safetensors or shapely" \
	    "(bindings/python/README.md; PYTHON=... names another)"; fi

models: build ## make data, train, judge and export the networks in models/ (hours)
	JOSTLE=$(JOSTLE) PYTHON=$(PYTHON) DATA=$(DATA) MINUTES=$(MINUTES) COUNT=$(COUNT) SAMPLES=$(SAMPLES) \
	    INTO=$(INTO) scripts/models.sh $(MODELS)

more-loop: build ## MORE's loop: search, learn, guide the search, again; a report after each round (docs/planners.md)
	@mkdir -p $(OUT)
	cd bindings/python && $(PYTHON) -m jostle_training.more_loop $(abspath $(OUT))/more-loop \
	    --jostle $(abspath $(JOSTLE)) $(MORE_LOOP)

install: ## library, headers, struct layouts, pkg-config, CMake package and tool, to DESTDIR and PREFIX (/usr/local)
	@test -e $(BUILD)/libjostle.so || $(MAKE) --no-print-directory build
	DESTDIR="$(DESTDIR)" PREFIX="$(PREFIX)" LIBDIR="$(LIBDIR)" INCLUDEDIR="$(INCLUDEDIR)" BUILD="$(BUILD)" \
	    scripts/install.sh install

uninstall: ## remove what install put there
	DESTDIR="$(DESTDIR)" PREFIX="$(PREFIX)" LIBDIR="$(LIBDIR)" INCLUDEDIR="$(INCLUDEDIR)" \
	    scripts/install.sh uninstall

clean: ## remove build products and out/
	$(CARGO) clean
	rm -rf $(OUT)
