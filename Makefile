# Every target sets up what it needs first; see scripts/set_up.sh.

bin := .venv/bin
# The tests run in two processes; more threads in each would only wait for one another.
one_thread := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 LP_NUM_THREADS=1
packages := tacos_framework plugins
# What a host that embeds the library relies on, checked as strictly as a host may.
embedding := tests/embedding/design_a_camera.py tests/embedding/public_types.py

.DEFAULT_GOAL := help
.PHONY: help setup demo test test-fast test-lowest test-pythons lint format docs slow mutants clean

help: ## Say what can be made
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /make \1\t/' | expand -t 14

setup: ## Set up the virtual environment with all that tests and checks need
	@scripts/set_up.sh dev

demo: ## Design a headset's camera in a few minutes; writes runs/demo/report.html
	@scripts/set_up.sh
	@scripts/demo.sh

test: lint ## Run all checks and tests, but for the slow ones
	$(one_thread) $(bin)/pytest -n 2 --dist loadfile --no-loadscope-reorder --doctest-modules tests $(packages)

# The folders whose tests take seconds: physics, contracts, recipes, plans, one task and report.
fast := camera catalog compiled controls core effects export files formation graph lighting plan plugins recipe rigs sensors settings simulation startup surrogate variables
test-fast: setup ## Run the tests that take under two minutes together
	$(one_thread) $(bin)/pytest -n 2 --doctest-modules $(fast:%=tests/%) tacos_framework

lint: setup ## Check style, formatting, types and layers
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/mypy
	$(bin)/mypy --strict --follow-imports=silent $(embedding)
	$(bin)/lint-imports

format: setup ## Put the code into its format
	$(bin)/ruff check --fix .
	$(bin)/ruff format .

docs: setup ## Write the generated pages anew, and build the documentation into site/
	$(bin)/python -m tacos_plugins.authoring.reference docs/reference
	$(bin)/python scripts/fill_docs.py
	NO_MKDOCS_2_WARNING=1 $(bin)/mkdocs build --strict --quiet
	@echo "open site/index.html"

test-lowest: ## Run a part of the tests with the lowest versions that pyproject.toml allows
	@scripts/smoke.sh lowest-direct python3.11

test-pythons: ## Run that part with the newest versions, on each Python from 3.11 to 3.14 that is installed
	@for version in 3.11 3.12 3.13 3.14; do \
	    ! python$$version -c '' 2>/dev/null || scripts/smoke.sh highest python$$version || exit 1; \
	done

slow: setup ## Run the slow tests (minutes each)
	$(bin)/pytest -m slow tests

mutants: ## See which small changes of the physics no test notices (a quarter of an hour)
	@scripts/set_up.sh mutants
	$(one_thread) scripts/mutants.sh

clean: ## Remove the virtual environment and all that tools left behind, but no runs
	rm -rf .venv .venv-smoke-* .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache .mutants dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
