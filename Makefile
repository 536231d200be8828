# On a fresh machine with Python 3.11+ and make: `make demo` shows what it does, `make test` checks it,
# `make test-all` checks it in all ways, `make docs` builds the documentation.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# What is imported is compiled then; compiling all of it takes longer than copying it.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt
LINKS ?= $(HOME)/.local/bin
# One BLAS thread a process: the matrices are small, and two processes share two cores.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

# What a terminal has set for another checkout, or for a service it asks, is none of this one's.
unexport PYTHONPATH PYTHONHOME PYTEST_ADDOPTS MODALLAB_TOKEN MODALLAB_TOKEN_FILE MODALLAB_DATA MODALLAB_DATABASE \
  MODALLAB_HOSTS MODALLAB_PORT

# A file to a worker, so that what its tests share is made once.
TESTS = $(BIN)/pytest -n auto --dist loadscope --no-loadscope-reorder

.PHONY: demo test test-all tests check docs command service clean
demo: $(VENV)/.ready
	$(BIN)/modallab demo --out demo

# Many tests wait, for a process or a device: the static checks run beside them.
test: $(VENV)/.tools
	@$(MAKE) --no-print-directory -j 2 tests check

# And what takes longer: each test says why, `pytest --markers` what a mark means.
test-all: test
	$(TESTS) -m thorough

tests: $(VENV)/.tools
	$(TESTS) -m "not thorough" --slowest-share 1/3

check: $(VENV)/.tools
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/pyrefly check
	$(BIN)/python docs/reference/check_words.py

# Puts the command on the path of every terminal, not only of one that has activated .venv.
command: $(VENV)/.ready
	@mkdir -p $(LINKS)
	@ln -sf $(abspath $(BIN))/modallab $(LINKS)/modallab
	@echo "modallab is now $(LINKS)/modallab"
	@case ":$$PATH:" in *":$(LINKS):"*) ;; *) echo "  what to do: add $(LINKS) to PATH, or run: . .venv/bin/activate";; esac

# Pages, references and notebooks as one folder that needs no network; MODALLAB_SITE=site serves it at /manual/.
docs: $(VENV)/.ready
	@$(INSTALL) -e '.[docs]'
	$(BIN)/python docs/site.py site
	@echo "open site/index.html"

# What the service needs to compute models and diagnoses, and to make a certificate of its own.
service: $(VENV)/.ready
	@echo "installing what the service computes with ..."
	$(INSTALL) -e '.[jobs,tls]'

$(VENV)/.ready: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit("modallab needs Python 3.11 or newer, this is " + sys.version.split()[0]) if sys.version_info < (3, 11) else None'
	@echo "1 of 3: making an environment in $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@echo "2 of 3: fetching and installing about 65 packages, 370 MB ..."
	@$(INSTALL) -e .
	@echo "3 of 3: looking whether it starts ..."
	@$(BIN)/modallab --version
	@echo "installed. To use the command in this terminal: . $(VENV)/bin/activate"
	@touch $@

$(VENV)/.tools: $(VENV)/.ready
	@echo "installing the development tools, about 450 MB; this takes some minutes ..."
	@$(INSTALL) -e '.[dev]'
	@touch $@

clean:
	rm -rf $(VENV) demo dist site .pytest_cache .ruff_cache .hypothesis
