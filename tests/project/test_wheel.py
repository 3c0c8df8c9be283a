"""The wheel, installed in an environment of its own, works as the checkout does."""

import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from dataclasses import dataclass
from email import message_from_bytes
from functools import partial
from pathlib import Path

import pytest

import stereotrack_core

ROOT = Path(__file__).resolve().parents[2]


def build(folder: Path, *options: str) -> Path:
    """Put a wheel of the checkout in a folder; without options, by way of an sdist there."""
    program = (sys.executable, "-m", "build", "--no-isolation", *options, "--outdir", str(folder))
    subprocess.run([*program, str(ROOT)], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return wheel


@dataclass(frozen=True)
class Installed:
    """An environment into which the wheel was installed."""

    wheel: Path
    environment: Path
    site_packages: Path

    def run(self, program, *arguments, folder, beside=None):
        """Run a program of this environment, away from the checkout and without a screen.

        Modules in the folder ``beside`` come first on Python's path.
        """
        variables = {
            name: value
            for name, value in os.environ.items()
            if name not in {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "DISPLAY", "WAYLAND_DISPLAY"}
        }
        variables |= {"QT_QPA_PLATFORM": "offscreen", "XDG_CONFIG_HOME": str(folder / "config")}
        if beside is not None:
            variables["PYTHONPATH"] = str(beside)
        done = subprocess.run(
            [str(self.environment / "bin" / program), *arguments],
            cwd=folder,
            env=variables,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=580,
        )
        assert done.returncode == 0, done.stderr
        return done


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Installed:
    folder = tmp_path_factory.mktemp("wheel")
    wheel = build(folder, "--wheel")
    environment = folder / "environment"
    venv.create(environment, symlinks=True)
    python = environment / "bin" / "python"
    site_packages = Path(
        subprocess.check_output(
            [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], text=True
        ).strip()
    )
    pip = (sys.executable, "-m", "pip", "--python", str(python), "install", "--no-index")
    subprocess.run([*pip, "--no-deps", "--quiet", str(wheel)], check=True, capture_output=True)
    # The dependencies come from the environment that runs the tests, behind the wheel's own
    # folder. Its .pth files are not read on this way, so that the checkout stays out of sight.
    (site_packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return Installed(wheel, environment, site_packages)


def test_the_wheel_carries_the_two_packages_and_nothing_else(installed):
    with zipfile.ZipFile(installed.wheel) as archive:
        names = archive.namelist()
    assert {name.split("/")[0].split("-")[0] for name in names} == {
        "stereotrack_app",
        "stereotrack_core",
        "stereotrack",
    }
    assert {"stereotrack_app/py.typed", "stereotrack_core/py.typed"} <= set(names)
    for folder in ("resources", "docs"):
        packed = {name for name in names if name.startswith(f"stereotrack_app/{folder}/")}
        present = {
            "stereotrack_app/" + path.relative_to(ROOT).as_posix()
            for path in (ROOT / folder).rglob("*")
            if path.is_file()
        }
        assert packed == present != set()


def test_the_wheel_says_its_licence_and_its_authors(installed):
    (licence,) = installed.site_packages.glob("stereotrack-*.dist-info/licenses/LICENSE")
    assert licence.read_bytes() == (ROOT / "LICENSE").read_bytes()
    said = message_from_bytes((licence.parents[1] / "METADATA").read_bytes())
    assert said["License-Expression"] == "BSD-3-Clause"
    assert said["License-File"] == "LICENSE"
    assert said["Author"] == "the stereotrack authors"
    assert said["Version"] == stereotrack_core.__version__


def test_a_wheel_from_the_sdist_is_the_same(installed, tmp_path):
    wheel = build(tmp_path)
    assert list(tmp_path.glob("*.tar.gz"))
    assert wheel.read_bytes() == installed.wheel.read_bytes()


WHERE_THINGS_ARE = """
import stereotrack_app, stereotrack_core
from PySide6.QtWidgets import QApplication
from stereotrack_app.widgets.style.theme import icon_named
from stereotrack_app.widgets.style.theme import data_folder

application = QApplication([])
print(stereotrack_app.__file__, stereotrack_core.__file__, data_folder("resources"), sep="\\n")
print(data_folder("docs"))
names = [path.stem for path in (data_folder("resources") / "icons").glob("*.svg")]
print(len(names), any(icon_named(name).isNull() for name in names))
"""


def test_code_and_resources_come_from_the_wheel(installed, tmp_path):
    done = installed.run("python", "-c", WHERE_THINGS_ARE, folder=tmp_path)
    *places, icons = done.stdout.splitlines()
    assert len(places) == 4
    for place in places:
        assert Path(place).is_relative_to(installed.site_packages), place
    drawings = list((ROOT / "resources" / "icons").glob("*.svg"))
    assert icons == f"{len(drawings)} False"


@pytest.mark.slow
def test_the_demo_runs_without_a_screen(installed, tmp_path):
    done = installed.run("stereotrack", "demo", "demo", "--headless", folder=tmp_path)
    for measure in ("torso", "upper arm", "forearm"):
        assert measure in done.stdout
    assert (tmp_path / "demo").is_dir()


@pytest.mark.slow
def test_a_foreign_package_called_app_does_no_harm(installed, tmp_path):
    foreign = tmp_path / "foreign" / "app"
    foreign.mkdir(parents=True)
    (foreign / "__init__.py").write_text('raise RuntimeError("this is not stereotrack")\n')
    run = partial(installed.run, "stereotrack", folder=tmp_path, beside=foreign.parent)
    small = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")
    run("simulate", "tiny", "--frames", "3", "--views", "N", *small)
    near = ("--set", "pixel_step=1", "--set", "outlier_neighbours=0", "--set", "least_points=10")
    run("track", "tiny", "-o", "tiny.npz", "--preset", "fast", "--init", "tpose", *near)
    run("open", "tiny", "--screenshot", "window.png")
    run("report", "tiny.npz", "-o", "report.html")
    assert (tmp_path / "window.png").stat().st_size > 0
    assert (tmp_path / "report.html").stat().st_size > 0
