# make rig   the paper's test, performed by three real ROS 2 processes
# make test  everything that proves it
# Both set themselves up in .venv from nothing: Python >= 3.10, make and a compiler are enough.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SCENARIO ?= vertical_sweep

export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST

.PHONY: rig test repeat lint soak transports benchmarks peers docs-picture browser clean

rig: .venv
	$(BIN)/qzs-rig rig $(SCENARIO)

test: .venv browser lint
	$(BIN)/python -m pytest

# the tests with real processes N times in one session, all failures counted: make repeat N=10
N ?= 10
repeat: .venv browser
	$(BIN)/python -m pytest --count $(N) --repeat-scope session -q test/ros test/faults test/cli

lint: .venv
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy qzs_rig

# one environment, made again when the package's needs change
.venv: setup.py pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10) and "Python >= 3.10 is needed: make PYTHON=python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --upgrade pip
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[ros,test]'
	touch $(VENV)

# the report is tested in a real browser
browser:
	@command -v chromium >/dev/null && command -v chromedriver >/dev/null || { \
	  echo 'installing chromium and chromium-driver'; \
	  if [ "$$(id -u)" = 0 ]; then S=; else S=sudo; fi; \
	  $$S apt-get update -qq && DEBIAN_FRONTEND=noninteractive $$S apt-get install -y -qq --no-install-recommends chromium chromium-driver >/dev/null; }

# the rig over each of Fast DDS's transports (docs/dependencies.md), without other load: 20 minutes
transports: .venv
	$(BIN)/python benchmarks/transports.py

# longer than a test should take: 60 s at 1 kHz by the clock, and a thousand seconds in lockstep
soak: .venv
	$(BIN)/python benchmarks/soak.py

benchmarks: .venv
	for file in benchmarks/plant_step.py benchmarks/geometric_step.py benchmarks/estimation.py benchmarks/bag_writing.py benchmarks/run_speed.py benchmarks/laws.py benchmarks/references.py benchmarks/bifurcation.py benchmarks/frequency_response.py benchmarks/campaign.py; do \
	  echo "== $$file"; $(BIN)/python $$file || exit 1; done

# the same beside other packages for it, which take minutes; benchmarks run without them too
peers: .venv
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[peers]'
	$(BIN)/python benchmarks/bifurcation.py --campaign
	$(BIN)/python -W ignore benchmarks/frequency_response.py

# the picture in the README
docs-picture: .venv
	$(BIN)/python docs/picture.py

clean:
	rm -rf $(VENV) build install log .pytest_cache .mypy_cache .ruff_cache *.egg-info
