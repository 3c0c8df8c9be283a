# make demo and make test do everything that is needed, on a fresh machine too.
.POSIX:
.PHONY: help demo test test-window test-slow test-newest test-oldest lint ready bundle docs docs-site pictures texts lock clean

# Number of processes that run tests.
WORKERS = 2
PY = .venv/bin/python
# Tests start many processes, none of which shall compile the program anew, whatever is usual here.
PYTEST = PYTHONDONTWRITEBYTECODE= QT_QPA_PLATFORM=offscreen OPENBLAS_NUM_THREADS=1 \
    $(PY) -m pytest --timeout 600

help:
	@echo 'make demo       track the demo recording, print its errors, show it in the workbench'
	@echo 'make test       lint, types, import contract and the fast tests that open no window'
	@echo 'make test-window  the fast tests that open windows'
	@echo 'make test-slow  the slow tests: accuracy, endurance, thousands of cases'
	@echo 'make test-newest  install a wheel with the newest versions of everything, and try it'
	@echo 'make test-oldest  the same with the oldest versions that pyproject.toml allows'
	@echo 'make bundle     a folder and an archive of the program that need no Python, and try them'
	@echo 'make lint       lint, types and import contract alone'
	@echo 'make docs       docs/parameters.md from the declared parameters'
	@echo 'make docs-site  the documentation as a site, in build/docs-site'
	@echo 'make pictures   the pictures of README and docs, made by the program'
	@echo 'make texts      every text that a person may read, with its place in the code'
	@echo 'make lock       requirements.lock from pyproject.toml (make lock UPGRADE=--upgrade: newest)'
	@echo 'make clean      remove the environment, caches and the demo recording'

ready:
	@python=$$(tools/find_python) && "$$python" tools/bootstrap.py

# The detector is a gain, no condition: without a network the demo goes on, and a line says so.
demo: ready
	@$(PY) -m app detector install --if-missing
	@if $(PY) tools/screen.py; then $(PY) -m app demo demo; \
	else QT_QPA_PLATFORM=offscreen $(PY) -m app demo demo --headless --screenshot demo/window.png; fi

test: lint
	$(PYTEST) -n $(WORKERS) --dist loadfile --no-loadscope-reorder -m 'not slow and not window'

test-window: ready
	$(PYTEST) -n $(WORKERS) --dist loadfile --no-loadscope-reorder -m 'window and not slow'

test-slow: ready
	$(PYTEST) -n $(WORKERS) --dist loadfile --no-loadscope-reorder -m slow --timeout 7200 --durations 0
	$(PY) tools/mutation_sample.py

# Each Python that is found; make test-newest NEWEST=3.12 tries another.
NEWEST = 3.11 3.13
OLDEST = 3.11

test-newest:
	@tried=; for version in $(NEWEST); do if python=$$(tools/find_python $$version); then \
	    tried=yes; "$$python" tools/fresh_install.py || exit 1; fi; done; [ "$$tried" ]

test-oldest:
	@python=$$(tools/find_python $(OLDEST)) && "$$python" tools/fresh_install.py --oldest

bundle:
	@python=$$(tools/find_python) && "$$python" tools/make_bundle.py

lint: ready
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	.venv/bin/lint-imports

docs: ready
	$(PY) tools/write_parameters.py docs/parameters.md

# A warning is an error: a link that leads nowhere, a notebook that fails.
docs-site: ready
	$(PY) -m sphinx -q -W --keep-going -c tools/docs_site . build/docs-site

pictures: ready
	PYTHONPATH=. $(PY) tools/write_pictures.py demo docs
	$(PY) tools/shrink_pictures.py docs/*.png

texts: ready
	@$(PY) tools/texts.py

lock: ready
	$(PY) -m venv --clear build/uv
	build/uv/bin/python -m pip install --quiet uv
	build/uv/bin/uv pip compile pyproject.toml --extra dev --extra docs --universal --python-version 3.11 \
	    --no-header --no-emit-index-url --annotation-style line --quiet $(UPGRADE) -o requirements.lock
	rm -rf build/uv

clean:
	rm -rf .venv build dist demo .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
