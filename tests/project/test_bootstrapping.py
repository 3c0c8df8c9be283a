"""The bootstrapping tools: which packages they would install, and that they install once."""

import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"


def tool(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """One of the scripts in tools/, which import one another by plain name."""
    monkeypatch.syspath_prepend(str(TOOLS))
    for other in ("debian", "bootstrap", name):
        monkeypatch.delitem(sys.modules, other, raising=False)
    spec = importlib.util.spec_from_file_location(name, TOOLS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("library", "package"),
    [
        ("libxcb-icccm.so.4", "libxcb-icccm4"),
        ("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
        ("libX11-xcb.so.1", "libx11-xcb1"),
        ("libX11.so.6", "libx11-6"),
        ("libdbus-1.so.3", "libdbus-1-3"),
        ("libEGL.so.1", "libegl1"),
        ("libgssapi_krb5.so.2", "libgssapi-krb5-2"),
        ("libglib-2.0.so.0", "libglib2.0-0"),
        ("libz.so.1", "zlib1g"),
    ],
)
def test_package_of_a_library(library, package, monkeypatch):
    assert tool("system_libraries", monkeypatch).package_of(library) == package


def test_missing_libraries_are_read_from_ldd(monkeypatch):
    output = (
        "/env/libqxcb.so:\n"
        "\tlinux-vdso.so.1 (0x00007ffc)\n"
        "\tlibxcb-icccm.so.4 => not found\n"
        "\tlibxcb.so.1 => /lib/x86_64-linux-gnu/libxcb.so.1 (0x00007f)\n"
        "\tlibxcb-keysyms.so.1 => not found\n"
    )
    missing = tool("system_libraries", monkeypatch).missing_in(output)
    assert missing == {"libxcb-icccm.so.4", "libxcb-keysyms.so.1"}


def test_without_the_right_to_install_the_one_command_is_printed(monkeypatch, capsys):
    module = tool("system_libraries", monkeypatch)
    monkeypatch.setattr(module.debian, "install", lambda packages: False)
    monkeypatch.setattr(module, "missing_now", lambda: (set(), {"libxcb-icccm.so.4"}))
    monkeypatch.setattr(module.sys, "platform", "linux")
    assert module.main([]) == 0, "without a screen the program still runs"
    assert "sudo apt-get install libxcb-icccm4" in capsys.readouterr().err
    assert module.main(["--window"]) == 1


@pytest.mark.skipif(os.name != "posix", reason="a shell script")
def test_a_python_that_refuses_to_run_is_passed_over(tmp_path):
    """As the shims of pyenv do for versions that are there and not chosen."""
    refuses = "echo 'pyenv: command not found' >&2; exit 127"
    for name, script in (("3.13", refuses), ("3.12", f'exec "{sys.executable}" "$@"')):
        command = tmp_path / f"python{name}"
        command.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        command.chmod(0o755)
    environment = {"PATH": f"{tmp_path}:/usr/bin:/bin", "HOME": str(tmp_path)}
    found = subprocess.check_output(["sh", TOOLS / "find_python"], env=environment, text=True)
    assert found.strip() == "python3.12"


def test_the_oldest_versions_are_those_that_are_declared(monkeypatch):
    module = tool("fresh_install", monkeypatch)
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    rows = [Requirement(row) for row in declared["dependencies"]]
    found = [Requirement(row) for row in module.oldest_allowed()]
    assert [(row.name, row.marker) for row in found] == [(row.name, row.marker) for row in rows]
    for row, oldest in zip(rows, found, strict=True):
        (specifier,) = oldest.specifier
        assert specifier.operator == "=="
        assert row.specifier.contains(specifier.version)
        assert f">={specifier.version}" in str(row.specifier)


def test_a_fresh_installation_does_not_see_the_checkout(monkeypatch):
    module = tool("fresh_install", monkeypatch)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    # Without site, because the tests' own environment has the checkout installed.
    show_path = [sys.executable, "-S", "-c", "import sys; print(*sys.path, sep=chr(10))"]
    for variables, seen in ((dict(os.environ), True), (module.variables(), False)):
        path = subprocess.check_output(show_path, cwd=ROOT, env=variables, text=True)
        assert bool({"", str(ROOT)} & set(path.splitlines())) is seen


def test_an_environment_that_is_up_to_date_is_left_alone(tmp_path, monkeypatch):
    module = tool("bootstrap", monkeypatch)
    monkeypatch.setattr(module, "STAMP", tmp_path / "stamp.json")
    monkeypatch.setattr(module, "PYTHON", Path(sys.executable))
    monkeypatch.delenv("PYTHON", raising=False)
    done: list[str] = []
    monkeypatch.setattr(module, "make_environment", lambda: done.append("environment"))
    monkeypatch.setattr(module, "install_project", lambda: done.append("project"))
    checked = subprocess.CompletedProcess[bytes]([], 0)
    version = "{}.{}".format(*sys.version_info)
    monkeypatch.setattr(module.subprocess, "check_output", lambda *_, **__: version)
    monkeypatch.setattr(module.subprocess, "run", lambda *_, **__: checked)

    assert module.main() == 0
    assert done == ["environment", "project"]
    assert module.main() == 0
    assert done == ["environment", "project"]

    monkeypatch.setattr(module, "wanted", lambda: {**module.installed(), "project": "edited"})
    assert module.main() == 0
    assert done == ["environment", "project", "project"]

    monkeypatch.setattr(module, "wanted", lambda: {**module.installed(), "lock": "edited"})
    assert module.main() == 0
    assert done[3:] == ["environment", "project"]
