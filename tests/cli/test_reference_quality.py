"""Errors are printed beside how good the reference is."""

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.interop.reference_npz import write_reference
from stereotrack_core.interop.run_file import read_trajectory

pytestmark = pytest.mark.xdist_group("cli")


def test_evaluate_says_how_good_the_reference_is(run, recording, tmp_path):
    truth = read_trajectory(recording / "reference.csv")
    frames = len(truth.frame)
    covariance = np.broadcast_to(1e-4 * np.eye(3), (frames, 9, 3, 3))
    stated = Reference(truth.frame, truth.points, covariance, np.full((frames, 6), 2.3))
    path = tmp_path / "fitted.npz"
    write_reference(path, stated)
    ended = run("evaluate", recording / "reference.csv", "--reference", path)
    assert ended.status == 0
    assert "reference uncertainty" in ended.out
    forearms = next(line for line in ended.out.splitlines() if line.strip().startswith("forearms"))
    assert forearms.split()[-1] == "2.3"
    assert "forearms 0.0 deg, reference uncertainty 2.3." in ended.out
    facts = run("evaluate", path, "--reference", path, "--json").json
    assert facts["measures"]["torso_position"]["reference_good_to"] == pytest.approx(17.3, abs=0.1)
    plain = run("evaluate", path, "--reference", recording / "reference.csv")
    assert "reference uncertainty" not in plain.out
