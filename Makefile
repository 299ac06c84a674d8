# `make run` and `make test` do everything on a fresh machine: virtual environment, install, job.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out/compare
READY := $(VENV)/.ready
COMPILED := $(VENV)/.compiled

.PHONY: run test check site study thresholds goldens picture gallery opengl browser clean

run: $(COMPILED)
	$(BIN)/graspcell compare --gap fitted --thresholds paper --experiments 20 --out $(OUT)
	$(BIN)/graspcell report $(OUT) --out $(OUT)/report.html

test: $(COMPILED) browser
	$(BIN)/python -m pytest -m "not study" -n 2 --dist loadfile

check: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(MAKE) site

# The pages of docs and the reference in out/site; a warning is an error.
site: $(READY)
	NO_MKDOCS_2_WARNING=1 PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/mkdocs build

# The thresholds that `compare` takes by default, for the error models as they are: some 10 minutes on 2 cores.
thresholds: $(COMPILED)
	$(BIN)/graspcell dataset --methods all --resamples 1 --out out/thresholds
	cp out/thresholds/thresholds.toml experiments/presets/derived.toml

# What every attempt of six experiments comes to, which the tests repeat as other processors would.
goldens: $(COMPILED)
	$(BIN)/python -m tests.goldens

# Measured trials of minutes: not part of `make test`. Those of learning need torch, those of clusters Ray.
study: $(COMPILED) browser
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev,learn,ray]'
	$(BIN)/python -m pytest -m study

# The picture in the README.
picture: $(COMPILED) opengl
	$(BIN)/graspcell picture --out docs/cell.png

# The pictures, the video and the report in docs/gallery, by the commands of docs/gallery.md: 11 minutes on 2 cores.
gallery: $(COMPILED) browser
	$(BIN)/python docs/make_gallery.py

# The system's OpenGL libraries, which only pictures and their tests need.
opengl:
	sh .ci/system-libraries

# These and Chromium, which the tests open reports in.
browser:
	sh .ci/system-libraries --browser

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "Python 3.11 or newer is needed: make PYTHON=python3.12 ...")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt --editable '.[dev]'
	touch $@

# Numba's kernels, compiled ahead. Its cache does not see an edit in another file, so all of them are compiled anew.
$(COMPILED): $(READY) $(wildcard maskval/*.py maskval/rendering/*.py sim/*.py sim/networks/*.py sim/runtime/*.py)
	find maskval sim -name '*.nb[ci]' -delete
	$(BIN)/python -m sim.runtime.compile_kernels
	touch $@

clean:
	rm -rf $(VENV) out .pytest_cache .mypy_cache .ruff_cache
