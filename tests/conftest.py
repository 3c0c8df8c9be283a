"""Fixtures that every room uses."""

import os
import signal
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings

from stereotrack_core.locks import FileLock
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE, detector_folder
from stereotrack_core.program import main

settings.register_profile(
    "repeatable",
    derandomize=True,
    max_examples=50,
    deadline=None,
    phases=set(Phase) - {Phase.shrink, Phase.explain},  # a failure took over 120 s with them
    suppress_health_check=[HealthCheck.too_slow],  # as a busy machine makes it
)
settings.load_profile("repeatable")

SHARED_RECORDINGS = Path(__file__).resolve().parents[2] / "shared" / "data" / "recordings"


def pytest_configure() -> None:
    """Make tests alike on all machines.

    Whether the pose detector is installed decides how runs come out; tests that ask for it look
    where it was (:mod:`tests.pose_model.installed`). Ctrl-C can be tested where a shell began the
    tests in the background and ignores it there.
    """
    installed_at = os.environ.setdefault("STEREOTRACK_TEST_DETECTOR", str(detector_folder()))
    os.environ[FOLDER_VARIABLE] = str(Path(installed_at) / "hidden from tests")
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


# A run that is not about how the person is found or measured, about what is looked at again, nor
# about exact depths: these take most of the time.
QUICK = (
    *("--preset", "fast", "--set", "fit_shape=no", "--set", "second_look=0"),
    *("--set", "least_focal=0"),
)
FAST = (*QUICK, "--init", "tpose")
SMALL = ("--set", "width=320", "--set", "height=240", "--set", "focal=200")


@pytest.fixture(scope="session")
def sound(tmp_path_factory) -> Path:
    """A rendered recording of two stereo views in which nothing is wrong, and a run beside it.

    The first process of tests makes them; all only read them. The pictures are so small that where
    limbs are, and whether enough of the body is seen, is a matter of chance.
    """
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "sound"
    while True:
        try:
            lock = FileLock(folder.with_suffix(".making"))
            break
        except BlockingIOError:
            time.sleep(0.05)
    try:
        run = folder.with_suffix(".npz")
        if not run.exists():
            words = ("--frames", "10", "--views", "NS", "--motion", "t-pose", *SMALL)
            assert main(["simulate", str(folder), *words]) == 0
            assert main(["track", str(folder), "-o", str(run), *FAST]) == 0
    finally:
        lock.release()
    return folder


@pytest.fixture(scope="session")
def whole(sound) -> Path:
    """A fast run of the sound recording."""
    return sound.with_suffix(".npz")


def shared_recording_folder(name: str) -> Path:
    """Folder of a recording that this project did not make; skips where it is absent."""
    folder = SHARED_RECORDINGS / name
    if not folder.is_dir():
        pytest.skip(f"the recording {name} is not beside this checkout")
    return folder


@pytest.fixture
def shared_recording():
    """Function from a recording's name to its folder."""
    return shared_recording_folder
