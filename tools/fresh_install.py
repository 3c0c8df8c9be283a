"""Installs a wheel of this checkout as anybody would, without the lock, and tries what it got.

Run by the Makefile with the Python to install for; needs nothing but the standard library. The
environment in build/ has the newest version of everything or, with ``--oldest``, the oldest
versions that pyproject.toml allows. There the demo is tracked, and tests are run on the installed
packages, the checkout out of sight.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

import bootstrap
import debian

ROOT = bootstrap.ROOT
TESTS = ("tests/recording", "tests/geometry", "tests/interop", "tests/project/test_wheel.py")
ONCE = "tests/project/test_wheel.py::test_the_demo_runs_without_a_screen"  # not again

WHAT_IS_INSTALLED = """
from importlib.metadata import requires, version
from packaging.requirements import Requirement
import stereotrack_core

rows = [Requirement(row) for row in requires("stereotrack")]
names = [row.name for row in rows if row.marker is None or row.marker.evaluate({"extra": ""})]
print(", ".join(f"{name} {version(name)}" for name in names))
print(stereotrack_core.__file__)
"""


def oldest_allowed() -> list[str]:
    """The lower bounds of pyproject.toml, as constraints for pip."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return [re.sub(r">=([\d.]+)[^;]*", r"==\1", row) for row in project["dependencies"]]


def variables() -> dict[str, str]:
    """Environment of the programs that are tried: no screen, and modules of no other place."""
    foreign = {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "DISPLAY", "WAYLAND_DISPLAY"}
    kept = {name: value for name, value in os.environ.items() if name not in foreign}
    alone = {"PYTHONSAFEPATH": "1", "PYTHONNOUSERSITE": "1"}
    return {**kept, **alone, "QT_QPA_PLATFORM": "offscreen", "OPENBLAS_NUM_THREADS": "1"}


def install(folder: Path, constraints: Sequence[str]) -> Path:
    """Make an environment with the wheel and what its tests need; return its Python."""
    bootstrap.new_environment(folder / "environment")
    python = folder / "environment" / "bin" / "python"
    pip = (str(python), "-m", "pip", "--disable-pip-version-check", "-qq", "--no-input")
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", str(folder), str(ROOT)], check=True)
    (wheel,) = folder.glob("*.whl")
    versions = folder / "constraints.txt"
    versions.write_text("\n".join(constraints), encoding="utf-8")
    debian.say("installing the wheel and its tests (a few minutes)")
    subprocess.run([*pip, "install", "--constraint", str(versions), f"{wheel}[dev]"], check=True)
    subprocess.run([python, ROOT / "tools" / "system_libraries.py"], check=True)
    return python


def try_out(python: Path, folder: Path, pytest_options: Sequence[str]) -> None:
    """Track the demo, which prints its table, and run tests on what is installed."""
    environment = variables()
    told = subprocess.check_output([python, "-c", WHAT_IS_INSTALLED], env=environment, text=True)
    versions, place = told.splitlines()
    if not Path(place).is_relative_to(folder):
        sys.exit(f"stereotrack: tried {place} in place of what was installed in {folder}")
    print(f"Python {sys.version.split()[0]}, {versions}", flush=True)
    demo = [str(python.with_name("stereotrack")), "demo", "demo", "--headless"]
    subprocess.run(demo, cwd=folder, env=environment, check=True)
    pytest = (str(python), "-m", "pytest", "-q", "--timeout", "600", "-m", "not slow")
    chosen = (*TESTS, "--deselect", ONCE, *pytest_options)
    subprocess.run([*pytest, *chosen], cwd=ROOT, env=environment, check=True)


def main(arguments: Sequence[str]) -> int:
    """Install and try; the status of the first step that fails."""
    oldest = "--oldest" in arguments
    name = "oldest" if oldest else "newest"
    folder = ROOT / "build" / f"{name}-{sys.version_info.major}.{sys.version_info.minor}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        python = install(folder, oldest_allowed() if oldest else ())
        # Old versions warn of what newer ones beside them have deprecated since.
        try_out(python, folder, ("-o", "filterwarnings=default") if oldest else ())
    except subprocess.CalledProcessError as error:
        debian.say(f"the {name} versions do not work (see above)")
        return error.returncode
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
