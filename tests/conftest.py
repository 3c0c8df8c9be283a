"""Fixtures that every room uses."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings

from stereotrack_core.pose_model.installation import FOLDER_VARIABLE, detector_folder

settings.register_profile(
    "repeatable",
    derandomize=True,
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
