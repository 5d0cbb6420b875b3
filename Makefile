# Two commands do everything: `make run` and `make test`. The rest are their parts.
SHELL := /bin/bash
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && echo $$p && break; done)
PY := .venv/bin/python
export PYTHONPATH := layers/service:layers/solver:.
# As the functions are given it: of small matrices a second thread waits for the first.
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: run test thorough lint unit service browser screenshots bench bench-keys bench-guidance bench-load bench-accuracy bench-consensus bench-uncertainty fuzz kills ops bundle openapi plan lock layers deploy deploy-plan rehearsal cost conformance checkov verify load clean setup

AUDIT := .build/audit/bin/pip-audit

run: setup
	@exec $(PY) -m infra.local

# Tests share nothing and mostly take one core or wait: two at a time take half the time.
PYTEST := $(PY) -m pytest
TWO := -n 2 --dist worksteal

test: lint
	node --test tests/web/
	$(PYTEST) $(TWO) tests/unit tests/service
	@$(MAKE) --no-print-directory browser

lint: setup
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	.venv/bin/cfn-lint template.yaml
	npx --no-install tsc -p web
	@test -x $(AUDIT) || ($(PYTHON) -m venv .build/audit && .build/audit/bin/pip install --quiet --retries 0 --timeout 10 pip-audit==2.10.1 2>/dev/null) || true
	@$(PY) -m infra.ci.audit

unit: setup
	node --test tests/web/
	$(PYTEST) $(TWO) tests/unit

service: setup
	$(PYTEST) $(TWO) tests/service

browser: setup
	@bash infra/ci/browsers.sh
	$(PYTEST) $(TWO) tests/browser

# Those tests too that take long and are left out of `make test`, and new examples where they are made up.
thorough: export THOROUGH := 1
thorough: browser
	$(PYTEST) $(TWO) -m thorough tests/unit

# Every page in every state, to be looked at: tests/browser/output/
screenshots: setup
	@bash infra/ci/browsers.sh
	$(PY) -m pytest tests/browser/screenshots.py

# One core for both sides of every ratio: libraries differ in how many they would take.
bench: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m tests.bench

# SEEDS=10 ONLY=methods,conditions,bound
bench-guidance: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m tests.bench.guidance

bench-accuracy: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m tests.bench.accuracy

bench-consensus: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m tests.bench.consensus

bench-uncertainty: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m tests.bench.uncertainty

# Does the key of a camera suffice? Writes docs/camera-keys.md.
bench-keys: setup
	@$(PY) -m tests.bench.keys

# 64 clients, 2,000 captures, a line that drops; SESSIONS= and CLIENTS= for other numbers
bench-load: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m tests.bench.crowd

# Captures from many clients at once, of any stack: ARGS="http://127.0.0.1:8000 --sessions 20"; --help says more
load: .venv/.made
	@$(PY) -m infra.load_test $(ARGS)

# Requests made of the OpenAPI document, and values of every schema, as many as CASES
fuzz: setup
	@CASES=$(or $(CASES),5000) $(PY) -m pytest tests/service/test_openapi_fuzz.py tests/unit/service/test_schema_fuzz.py

# kill -9 while captures end, at as many moments as KILLS
kills: setup
	@CALIBDB_KILLS=$(or $(KILLS),54) $(PY) -m pytest -s tests/service/test_killed_while_finishing.py

# make ops ARGS="token create --origin https://page.example"
ops: .venv/.made
	@$(PY) -m infra.ops $(ARGS)

# What is reliable of the cameras that most people have, for web applications to carry. FILE= MOST= for others than these
bundle: .venv/.made
	@$(PY) -m infra.ops bundle $(or $(FILE),.build/cameras.json) --most $(or $(MOST),500)

openapi: .venv/.made
	$(PY) -m infra.web_build.openapi

plan: .venv/.made
	$(PY) -m infra.web_build.plan

# ---- what the above need, made once and again when its lock file changes
# (the marks stand inside what they mark, so that removing it is enough to have it made anew)
setup: .venv/.made node_modules/.made web/vendor/api.d.ts

.venv/.made: requirements.lock
	@test -n "$(PYTHON)" || { echo "calibDB needs Python 3.11 to 3.13"; exit 1; }
	@test -x $(PY) || $(PYTHON) -m venv .venv
	$(PY) -m pip install --quiet --retries 10 --require-hashes -r requirements.lock
	@touch $@

node_modules/.made: package-lock.json
	npm ci --silent --fetch-retries 5
	@touch $@

web/vendor/api.d.ts: node_modules/.made infra/web_build/vendor.mjs infra/web_build/engines.mjs web/openapi.json
	node infra/web_build/vendor.mjs
	@touch $@

# ---- upkeep
UV := .build/uv/bin/uv
COMPILE := $(UV) pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header --no-annotate

$(UV):
	$(PYTHON) -m venv .build/uv && .build/uv/bin/pip install --quiet uv

lock: $(UV)
	$(COMPILE) --group dev -o requirements.lock
	$(COMPILE) --group service -c requirements.lock -o layers/service/requirements.lock
	$(COMPILE) --group solver -c requirements.lock -o layers/solver/requirements.lock
	npm install --package-lock-only
	node infra/ci/lock.mjs

# Both layers for Lambda's arm64 in .build/layers
LAYER = env -u PYTHONPATH $(MAKE) --silent UV=$(abspath $(UV)) COMPILE="node $(abspath infra/deploy/compile.mjs)"

layers: $(UV) .venv/.made node_modules/.made
	@rm -rf .build/layers
	@$(LAYER) -C layers/service build-ServiceLayer ARTIFACTS_DIR=$(abspath .build/layers/service)
	@$(LAYER) -C layers/solver build-SolverLayer ARTIFACTS_DIR=$(abspath .build/layers/solver)
	@$(PY) -m infra.deploy.layers

MINISTACK := .build/ministack/bin/hypercorn

$(MINISTACK):
	$(PYTHON) -m venv .build/ministack && .build/ministack/bin/pip install --quiet ministack==1.5.33 aws-sam-translator==1.115.0

SAM := .build/sam/bin/sam

$(SAM):
	$(PYTHON) -m venv .build/sam && .build/sam/bin/pip install --quiet aws-sam-cli==1.170.0

# make deploy STACK=calibdb AWS_REGION=us-east-1 ARGS="AlarmEmail=ops@example.org DomainName=… CertificateArn=…"
deploy: setup $(UV) $(SAM)
	@$(PY) -m infra.deploy $(ARGS)

# The same without doing anything, and without credentials
deploy-plan: setup
	@$(PY) -m infra.deploy --plan $(ARGS)

# The deployment itself, all but its last question, into another program's AWS on this machine
rehearsal: setup $(UV) $(SAM) $(MINISTACK)
	@$(PY) -m infra.deploy.rehearsal

# What a million lookups cost, and a calibration, by calls, durations and sizes measured here
cost: setup
	@OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(PY) -m infra.cost

# The storage tests against another implementation of AWS than moto
conformance: setup $(MINISTACK)
	@$(PY) -m infra.ci.conformance

CHECKOV := .build/checkov/bin/checkov

$(CHECKOV):
	$(PYTHON) -m venv .build/checkov && .build/checkov/bin/pip install --quiet checkov==3.3.30

# Is the deployment as careful as others' rules have it? infra/checkov.yaml argues with those it does not follow.
checkov: $(CHECKOV)
	$(CHECKOV) --config-file infra/checkov.yaml --skip-download -f template.yaml

# All that other people's programs say of the deployment, each in an environment of its own
verify: checkov conformance rehearsal

clean:
	rm -rf .venv .build node_modules web/vendor
