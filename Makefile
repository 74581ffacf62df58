# The commands of the workbench.  DATA: folder of recordings; OUT: where results go;
# ONLY: one notebook's name, or a part of it.
PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/python
PEERS := .venv-peers
OUT ?= build
ONLY ?=
ifdef DATA
export MCNLAB_DATA := $(abspath $(DATA))
endif
export PYDEVD_DISABLE_FILE_VALIDATION := 1

.PHONY: reproduce test lab bench notebooks docs

reproduce: $(VENV)/.made
	$(RUN) -m mcnlab reproduce --out "$(OUT)" --only "$(ONLY)"

test: $(VENV)/.made
	$(RUN) -m ruff check .
	$(RUN) -m ruff format --check .
	$(RUN) -m mypy
	$(RUN) -m pytest tests -n 2 -q
	env -u MCNLAB_DATA MPLBACKEND=Agg $(RUN) -m pytest --doctest-modules mcnlab -n 2 -q
	env -u MCNLAB_DATA $(RUN) -m pytest notebooks --nbval --nbval-current-env \
		--nbval-cell-timeout=120 -n 2 --dist loadscope -q -o filterwarnings=default

lab: $(VENV)/.made
	$(RUN) -m jupyterlab notebooks

bench: $(VENV)/.made $(PEERS)/.made
	MCNLAB_PEERS="$(abspath $(PEERS))/bin/python" $(RUN) -m bench --out "$(OUT)"

# Re-run the notebooks in place; outputs and counts stay, what changes by itself goes.
notebooks: $(VENV)/.made
	env -u MCNLAB_DATA $(RUN) -m mcnlab refresh --only "$(ONLY)"
	$(RUN) -m ruff check notebooks
	$(RUN) -m ruff format --check notebooks

docs: $(VENV)/.made
	env -u MCNLAB_DATA MPLBACKEND=Agg $(RUN) -m pdoc --docformat numpy --output-directory "$(OUT)/docs" \
		mcnlab '!mcnlab.__main__'

$(VENV)/.made: environment.txt
	rm -rf $(VENV)
	$(PYTHON) -m venv $(VENV)
	$(RUN) -m pip install --quiet --disable-pip-version-check -r environment.txt
	touch $@

$(PEERS)/.made: peers.txt
	rm -rf $(PEERS)
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check -r peers.txt
	touch $@
