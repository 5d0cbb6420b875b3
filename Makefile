# `make run` and `make test` do everything; `make help` lists the other commands.
SHELL := /bin/bash
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && echo $$p && break; done)
PY := .venv/bin/python
export PYTHONPATH := layers/service:layers/solver:.
# As the functions are given it: of small matrices a second thread waits for the first.
export OPENBLAS_NUM_THREADS ?= 1
# Each module is compiled once, whatever the environment says: the tests start Python a hundred times.
export PYTHONPYCACHEPREFIX ?= $(CURDIR)/.build/pycache
unexport PYTHONDONTWRITEBYTECODE

# What the commands need, made once and again when its lock file changes; Python's and npm's packages at the same time
SETUP := .setup
UV := .venv/bin/uv
INSTALL_UV := $(PY) -m pip install --quiet --no-compile --require-hashes -r infra/ci/uv.lock
PYTEST := $(PY) -m pytest
# Tests share nothing and mostly take one core or wait: two at a time take half the time.
TWO := -n 2 --dist worksteal
# Whole modules, so that a fixture of a module is made once; in the order of tests/conftest.py, the longest first.
# Three at a time: a fifth of the time they wait for processes that they start and stop, or for a browser.
MODULES := -n 3 --dist loadscope --no-loadscope-reorder
# The longest first, for two at a time; each begins as soon as the packages that it needs are there.
CHECKS := .mypy .cfn-lint .tsc .prettier .ruff .wording .imports .audit
# Tests under node that have OpenCV draw boards
DRAWN := tests/web/geometry.test.mjs
# The test under node that installs Vite and webpack
BUNDLED := tests/web/bundlers.test.mjs
PAIRED := --no-print-directory --jobs 2 --output-sync
# One core for both sides of every ratio: libraries differ in how many they would take.
ONE_CORE := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
COMMA := ,
words_of = $(subst $(COMMA), ,$(1))

.PHONY: help run test lint unit service browser thorough bench ops release lock layers deploy verify clean

help: ## list the commands
	@sed -nE 's/^([a-z]+):.*## (.*)/\1\t\2/p' $(MAKEFILE_LIST) | expand -t 12

run: $(SETUP) ## run the service on this machine: page and API on http://127.0.0.1:8000
	@exec $(PY) -m infra.server

test: ## run everything below up to browser
	@$(MAKE) $(PAIRED) .node .drawn .site $(CHECKS)
	@$(MAKE) --no-print-directory --jobs 4 .quiet-solver .quiet-unit .quiet-service .in-browsers

lint: ## check style, types, imports, wording, the template, and dependencies for known vulnerabilities
	@$(MAKE) $(PAIRED) $(CHECKS)

.node .drawn .site .tsc .prettier: web/vendor/api.d.ts
.drawn .ruff .wording .imports .mypy .cfn-lint .audit: .venv/.made

.node:
	node tests/web/together.mjs $(filter-out $(DRAWN) $(BUNDLED),$(wildcard tests/web/*.test.mjs))

.drawn:
	node --test $(DRAWN)

# Once for all servers that the tests start
.site:
	@$(PY) -c "from infra.web_build.site import made_files; made_files()"

.ruff:
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

.wording:
	@$(PY) -m infra.ci.wording

.imports:
	@PYTHONPATH=$(PYTHONPATH):clients/python .venv/bin/lint-imports --no-logo --cache-dir .build/imports

.mypy:
	$(PY) -m mypy

.cfn-lint:
	@$(PY) -m infra.deploy.package .build/template.yaml
	.venv/bin/cfn-lint .build/template.yaml

.prettier:
	npx --no-install prettier --check --log-level warn '{web,infra,tests}/**/*.{js,mjs}'

.tsc:
	npx --no-install tsc -p web

.audit:
	@$(PY) -m infra.ci.audit

unit: $(SETUP) .node .drawn ## test one package at a time, without sockets, and the web client's modules under node
	$(PYTEST) $(MODULES) tests/unit

service: $(SETUP) ## test HTTP against the server, and on emulated AWS
	$(PYTEST) $(MODULES) tests/service tests/aws

browser: $(SETUP) .in-browsers ## test the pages in Chromium and Firefox

# One after the other, the tests that need a whole browser for themselves last: people hold a board in real time.
.in-browsers:
	@bash infra/ci/browsers.sh
	$(PYTEST) $(MODULES) -m "not alone" tests/browser
	$(PYTEST) -m alone tests/browser || test $$? = 5  # none of them without CALIBDB_DATA

# The browsers come first, since they end last. The others keep a share: a request has 30 s to be answered. Each of the
# three takes as long as the others.
.quiet-solver:
	nice -n 5 $(PYTEST) tests/unit/solver

.quiet-unit:
	nice -n 5 $(PYTEST) --ignore=tests/unit/solver tests/unit tests/aws

.quiet-service:
	nice -n 5 $(PYTEST) tests/service

thorough: export THOROUGH := 1
thorough: $(SETUP) ## run the slow tests too; ONLY=browser,unit,kills,fuzz KILLS=54 CASES=5000 FILES=100000
	@$(MAKE) --no-print-directory $(addprefix .thorough-,$(call words_of,$(or $(ONLY),browser,unit,kills,fuzz)))

.thorough-browser: browser

.thorough-unit:
	$(PYTEST) $(TWO) -m thorough tests/unit tests/service tests/aws

# kill -9 of two processes while captures end, at as many moments as KILLS
.thorough-kills:
	CALIBDB_KILLS=$(or $(KILLS),54) $(PYTEST) -s tests/service/test_killed_while_finishing.py

# As many requests made of the OpenAPI document, and values of every schema, as CASES, and files as FILES; others with SEED=1
.thorough-fuzz:
	CASES=$(or $(CASES),5000) FILES=$(or $(FILES),100000) SEED=$(or $(SEED),0) $(PYTEST) \
		tests/service/test_openapi_fuzz.py tests/service/test_foreign_files.py \
		tests/unit/service/schema/test_schema_fuzz.py tests/service/test_raw_requests.py

kills fuzz:
	@$(MAKE) --no-print-directory thorough ONLY=$@

bench: export PYTHONPATH := $(PYTHONPATH):clients/python
bench: $(SETUP) ## print the budgets, ONLY=solver,lookup; or regenerate figures, DOCS=accuracy,capture,guidance,hand,consensus,uncertainty,extrapolation,domain,honesty,real-views,board-shape,real-contributors,rigs,frc,keys,estimates,load,memory,capacity,cost,slowest,page-speed
ifdef DOCS
	@set -e; for name in $(call words_of,$(DOCS)); do $(MAKE) --no-print-directory .bench-$$name; done
else
	@$(ONE_CORE) $(PY) -m tests.bench
endif

.bench-%: export PYTHONPATH := $(PYTHONPATH):clients/python

# The first lines of each module name its options, such as SEEDS=10.
.bench-%:
	@$(ONE_CORE) $(PY) -m tests.bench.$(subst -,_,$*)

.bench-load:
	@$(PY) -m tests.bench.crowd

bench-%:
	@$(MAKE) --no-print-directory bench DOCS=$*

cost:
	@$(MAKE) --no-print-directory bench DOCS=$@

ops: .venv/.made ## run the operator's command line; ARGS="token create --origin https://page.example"
	@$(PY) -m infra.ops $(ARGS)

release: $(SETUP) $(UV) ## ARGS="bump 0.2.0" sets the version; ARGS="build --tag v0.2.0" builds the artifacts of a clean checkout
	@$(PY) -m infra.release $(ARGS)

.setup:
	@$(MAKE) --silent --jobs 2 .venv/.made web/vendor/api.d.ts

# ---- the environment (a mark stands inside what it marks, so that removing that is enough to have it made anew)
.venv/.made: requirements.lock infra/ci/uv.lock
	@test -n "$(PYTHON)" || { echo "calibDB needs Python 3.11 to 3.13"; exit 1; }
	@test -x $(PY) || $(PYTHON) -m venv .venv
	@# uv takes a fifth of pip's time; pip does as well where uv or its packages cannot be had
	@$(INSTALL_UV) --retries 0 --timeout 10 2>/dev/null || true
	@UV_HTTP_TIMEOUT=10 $(UV) pip install --quiet --python $(PY) --require-hashes -r requirements.lock 2>/dev/null || \
		$(PY) -m pip install --quiet --no-compile --retries 10 --require-hashes -r requirements.lock
	@touch $@

node_modules/.made: package-lock.json
	npm ci --silent --fetch-retries 5
	@touch $@

web/vendor/api.d.ts: node_modules/.made infra/web_build/vendor.mjs infra/web_build/engines.mjs infra/web_build/detector/opencv.json infra/web_build/dictionaries.py .build/openapi.json
	node infra/web_build/vendor.mjs
	@$(PY) -m infra.web_build.dictionaries
	@touch $@

CALLS := $(wildcard functions/*/*.py layers/service/calibdb/schema/*.py infra/web_build/*.py)

.build/examples.json: .venv/.made $(CALLS)
	@$(PY) -m infra.web_build.recorded_examples

.build/openapi.json: .build/examples.json web/templates/docs/calls.md $(CALLS)
	@mkdir -p $(@D)
	@$(PY) -m infra.web_build.openapi $@

# ---- upkeep
COMPILE := $(UV) pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header --no-annotate

$(UV): .venv/.made
	@test -x $@ || $(INSTALL_UV)

lock: $(UV) ## write the lock files anew
	echo uv | $(COMPILE) -o infra/ci/uv.lock -
	$(COMPILE) --group dev -o requirements.lock
	$(COMPILE) --group service -c requirements.lock -o layers/service/requirements.lock
	$(COMPILE) --group solver -c requirements.lock -o layers/solver/requirements.lock
	npm install --package-lock-only
	node infra/ci/lock.mjs

layers: .layer-service .layer-solver ## build both layers for arm64 in .build/layers
	@$(PY) -m infra.deploy.layers

# Without the layers' sources in PYTHONPATH
.layer-%: $(UV) .venv/.made node_modules/.made
	@echo "install and compile the $* layer"
	@rm -rf .build/layers/$*
	@env -u PYTHONPATH $(MAKE) --silent -C layers/$* ARTIFACTS_DIR=$(CURDIR)/.build/layers/$* UV=$(abspath $(UV)) \
		COMPILE="node $(CURDIR)/infra/deploy/compile.mjs"

MINISTACK := .build/ministack/bin/hypercorn

$(MINISTACK):
	$(PYTHON) -m venv .build/ministack && .build/ministack/bin/pip install --quiet ministack==1.5.33 aws-sam-translator==1.115.0

SAM := .build/sam/bin/sam

$(SAM):
	$(PYTHON) -m venv .build/sam && .build/sam/bin/pip install --quiet aws-sam-cli==1.170.0

deploy: $(SETUP) $(UV) $(SAM) ## deploy; STACK=calibdb AWS_REGION=us-east-1 ARGS="AlarmEmail=ops@example.org"; ARGS=--plan shows the steps
	@$(PY) -m infra.deploy $(ARGS)

CHECKOV := .build/checkov/bin/checkov

$(CHECKOV):
	$(PYTHON) -m venv .build/checkov && .build/checkov/bin/pip install --quiet checkov==3.3.30

verify: $(SETUP) ## check the deployment and the packages with other people's programs; ONLY=checkov,conformance,rehearsal,pins,bundlers
	@set -e; for name in $(call words_of,$(or $(ONLY),checkov,conformance,rehearsal,pins,bundlers)); do $(MAKE) --no-print-directory .verify-$$name; done

# infra/checkov.yaml argues for the rules that are not followed.
.verify-checkov: $(CHECKOV)
	@$(PY) -m infra.deploy.package .build/template.yaml
	$(CHECKOV) --config-file infra/checkov.yaml --skip-download -f .build/template.yaml

# The storage tests against another implementation of AWS than moto, whose lenience hides differences
.verify-conformance: $(MINISTACK)
	@$(PY) -m infra.ci.ministack $(PYTEST) -q $(addprefix tests/unit/store/test_,ports.py aws.py store.py calibrations.py names.py)

# Tests that need only calibsolver and the client
PINNED := $(addprefix tests/unit/solver/,fitting/test_fit.py fitting/test_rivals.py \
	formats/test_foreign_models.py formats/test_conversion_error.py test_locate.py rig/test_fit.py) \
	$(addprefix tests/unit/client/test_,boards_in_pictures.py circles.py files.py fix.py undistort_and_check.py)

# calibsolver and the client with the lowest and the highest versions of Python, numpy and OpenCV that they permit
.verify-pins: $(UV) .venv/.made
	@$(MAKE) --no-print-directory .pinned-lowest-direct OF=3.10
	@$(MAKE) --no-print-directory .pinned-highest OF=3.13

.pinned-%:
	@$(UV) venv --quiet --clear --python $(OF) .build/pins/$*
	@$(UV) pip install --quiet --python .build/pins/$* --resolution $* './layers/solver[opencv]' './clients/python[opencv]'
	@$(UV) pip install --quiet --python .build/pins/$* pytest pytest-xdist hypothesis pyyaml
	@.build/pins/$*/bin/python -c "import sys, numpy, cv2; print('$*:', sys.version.split()[0], numpy.__version__, cv2.__version__)"
	@PYTHONPATH=. .build/pins/$*/bin/python -m pytest -q --confcutdir=tests/unit -m "not thorough and not external_data" $(PINNED)

# The SDK's package in the builds of Vite and webpack
.verify-bundlers: web/vendor/api.d.ts
	node --test $(BUNDLED)

# A deployment into another program's AWS on this machine
.verify-rehearsal: $(UV) $(SAM) $(MINISTACK)
	@$(PY) -m infra.deploy.rehearsal

checkov conformance rehearsal pins bundlers:
	@$(MAKE) --no-print-directory verify ONLY=$@

clean: ## remove everything that make made
	rm -rf .venv .build node_modules web/vendor
