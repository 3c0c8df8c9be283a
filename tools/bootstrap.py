"""Makes the environment .venv with the locked versions; does nothing when it stands already.

Run by the Makefile with any Python from 3.11 to 3.14; needs nothing but the standard library.
"""

import hashlib
import importlib.util
import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import debian

ROOT = Path(__file__).resolve().parents[1]
ENVIRONMENT = ROOT / ".venv"
PYTHON = ENVIRONMENT / "bin" / "python"
STAMP = ENVIRONMENT / "stereotrack-installed.json"
LOCK = ROOT / "requirements.lock"
PIP = (str(PYTHON), "-m", "pip", "--disable-pip-version-check", "-qq", "--no-input")


_VERSION = "import sys; print('{}.{}'.format(*sys.version_info))"


def wanted() -> dict[str, str]:
    """What the environment must have been made from."""
    return {
        "folder": str(ROOT),  # scripts in an environment hold its absolute path
        "lock": _digest(LOCK),
        "project": _digest(ROOT / "pyproject.toml"),
        "system": sysconfig.get_platform(),
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def installed() -> dict[str, str]:
    """What the environment was made from; empty where there is none or it does not run."""
    try:
        stamp: dict[str, str] = json.loads(STAMP.read_text(encoding="utf-8"))
        version = subprocess.check_output([PYTHON, "-c", _VERSION], text=True).strip()
    except (OSError, ValueError, subprocess.CalledProcessError):
        return {}
    asked_for = os.environ.get("PYTHON")
    if asked_for and version != "{}.{}".format(*sys.version_info):
        return {}
    return stamp


def new_environment(folder: Path) -> None:
    """Make an environment with the running Python, after what Debian keeps in a package apart."""
    version = "{}.{}".format(*sys.version_info)
    package = f"python{version}-venv"
    if importlib.util.find_spec("ensurepip") is None and not debian.install([package]):
        debian.say(f"this Python {version} cannot create virtual environments")
        sys.exit(f"stereotrack: install: {debian.install_command([package])}")
    debian.say(f"creating {folder.relative_to(ROOT)} with Python {version}")
    subprocess.run([sys.executable, "-m", "venv", "--clear", folder], check=True)


def make_environment() -> None:
    """Make .venv anew and install the locked versions."""
    new_environment(ENVIRONMENT)
    debian.say("installing the locked versions (a few minutes the first time)")
    subprocess.run([*PIP, "install", "--no-deps", "--requirement", LOCK], check=True)


def install_project() -> None:
    """Install the project itself, so that it runs from this folder."""
    editable = ("install", "--no-deps", "--no-build-isolation", "--editable", str(ROOT))
    subprocess.run([*PIP, *editable], check=True)


def main() -> int:
    """Bring the environment up to date."""
    target, present = wanted(), installed()
    if present == target:
        return 0
    try:
        if {**present, "project": target["project"]} != target:
            STAMP.unlink(missing_ok=True)
            make_environment()
        install_project()
    except subprocess.CalledProcessError as error:
        debian.say("the environment could not be created (see above); check the network connection")
        return error.returncode
    libraries = subprocess.run([PYTHON, ROOT / "tools" / "system_libraries.py"])
    if libraries.returncode == 0:
        STAMP.write_text(json.dumps(target, indent=1), encoding="utf-8")
    return libraries.returncode


if __name__ == "__main__":
    sys.exit(main())
