"""The detector's files: taken from wheels and folders, checked, kept, fetched with pip."""

import subprocess

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.detector import load_detector, required_detector
from stereotrack_core.pose_model.installation import (
    HEAVY,
    MODEL_FILES,
    detector_versions,
    install,
    installation,
    is_installed,
    landmark_file,
)
from stereotrack_core.program import main
from tests.pose_model.small_files import CONTENTS, LARGE, npm_archive, use_small_files, wheel

FINDER = MODEL_FILES[0].name


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The user's folder, in which nothing is installed; files as small as CONTENTS are right."""
    return use_small_files(monkeypatch, tmp_path / "kept")


def kept(folder) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*")} if folder.is_dir() else {}


def test_files_come_out_of_a_wheel(folder, tmp_path):
    assert set(installation().files.values()) == {"missing"}
    assert not is_installed()
    state = install(wheel(tmp_path / "mediapipe.whl"))
    assert kept(folder) == CONTENTS
    assert set(state.files.values()) == {"installed"}
    assert state.folder == folder


def test_files_come_out_of_a_folder(folder, tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    for name, content in CONTENTS.items():
        (given / name).write_bytes(content)
    install(given)
    assert kept(folder) == CONTENTS


def test_the_larger_network_is_added_from_its_archive(folder, tmp_path, capsys):
    install(wheel(tmp_path / "mediapipe.whl"))
    assert landmark_file(folder) == MODEL_FILES[1].name
    assert not detector_versions()
    with pytest.raises(InputError, match=r"heavy\.tflite is not the known file"):
        install(npm_archive(tmp_path / "wrong.tgz", LARGE[::-1]))
    state = install(npm_archive(tmp_path / "mediapipe-pose.tgz"))
    assert kept(folder) == {**CONTENTS, HEAVY.name: LARGE}
    assert state.files[HEAVY.name] == "installed"
    assert landmark_file(folder) == HEAVY.name
    assert detector_versions() == {"pose landmarks": "heavy"}
    assert main(["detector"]) == 0
    assert "more exact" in capsys.readouterr().out


@pytest.mark.parametrize("changed", [b"Content of pose_detection.tflite", b"short"])
def test_other_files_are_refused_and_what_was_there_stays(folder, tmp_path, changed):
    install(wheel(tmp_path / "right.whl"))
    wrong = wheel(tmp_path / "wrong.whl", {**CONTENTS, FINDER: changed})
    with pytest.raises(InputError, match=f"{FINDER} is not the known file.*Nothing was installed"):
        install(wrong)
    assert kept(folder) == CONTENTS


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda path: wheel(path, {FINDER: CONTENTS[FINDER]}), "pose_landmark_full.tflite is not"),
        (lambda path: path.write_bytes(b"no wheel"), "neither a wheel nor a folder"),
        (lambda path: path.mkdir(), f"{FINDER} is not in it"),
        (lambda path: None, "no such file"),
    ],
)
def test_what_holds_no_detector_is_refused(folder, tmp_path, make, message):
    make(tmp_path / "given")
    with pytest.raises(InputError, match=message):
        install(tmp_path / "given")
    assert kept(folder) == {}


def test_a_damaged_file_is_told(folder, tmp_path, capsys):
    install(wheel(tmp_path / "right.whl"))
    (folder / FINDER).write_bytes(b"damaged")
    assert installation().files[FINDER] == "damaged"
    assert load_detector() is None
    with pytest.raises(InputError, match=r"not installed.*stereotrack detector install"):
        required_detector()
    assert main(["detector"]) == 0
    assert "damaged" in capsys.readouterr().out


def test_a_missing_runtime_is_told(folder, tmp_path, monkeypatch, capsys):
    install(wheel(tmp_path / "right.whl"))
    monkeypatch.setattr("stereotrack_core.pose_model.installation.has_runtime", lambda: False)
    assert load_detector() is None
    with pytest.raises(InputError, match=r"ai-edge-litert.*pip install ai-edge-litert"):
        required_detector()
    assert main(["detector"]) == 0
    assert "pip install ai-edge-litert" in capsys.readouterr().err


def test_the_command_installs_and_tells(folder, tmp_path, capsys):
    assert main(["detector", "install", str(wheel(tmp_path / "right.whl")), "--json"]) == 0
    out = capsys.readouterr().out
    assert str(folder) in out
    assert '"licence": "Apache-2.0"' in out


class _Pip:
    """pip as a process that puts a wheel into the folder, or fails."""

    def __init__(self, command, *, fails=False, hangs=False, **_):
        self.returncode, self._hangs, self._fails = 1 if fails or hangs else 0, hangs, fails
        assert command[1:4] == ["-m", "pip", "download"]
        if not (fails or hangs):
            wheel(f"{command[command.index('--dest') + 1]}/mediapipe.whl")

    def communicate(self, timeout=None):
        if self._hangs and timeout is not None:
            raise subprocess.TimeoutExpired("pip", timeout)
        return "", "WARNING: retrying\nERROR: No matching distribution found\n" * self._fails

    def kill(self):
        pass


def test_without_a_file_pip_fetches_the_wheel(folder, monkeypatch):
    told = []
    monkeypatch.setattr(subprocess, "Popen", _Pip)
    install(say=told.append)
    assert kept(folder) == CONTENTS
    assert "mediapipe==0.10.21 (36 MB)" in told[0]


def test_without_a_network_the_way_by_hand_is_told(folder, monkeypatch, capsys):
    monkeypatch.setattr(subprocess, "Popen", lambda *a, **k: _Pip(*a, fails=True, **k))
    with pytest.raises(InputError, match=r"No matching distribution.*detector install FILE\.whl"):
        install()
    assert main(["detector", "install", "--if-missing"]) == 0  # as `make demo` does
    assert "everything else works" in capsys.readouterr().err
