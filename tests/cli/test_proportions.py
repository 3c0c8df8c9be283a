"""``stereotrack proportions``."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.program import main
from stereotrack_core.recording.description import read_subject
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import pose_with_arms

TALL = Proportions(0.41, 0.24, 0.51, 0.315, 0.275, 0.205, 0.225)
QUICK = (
    *("--preset", "fast", "--init", "tpose", "--set", "search_arms=false"),
    *("--set", "data_points=400", "--set", "pixel_step=1", "--set", "speckle_size=0"),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    poses = [
        pose_with_arms(
            [1, 0.2 * k, 0.1 * k],
            [1 - 0.3 * k, 0.4 * k, 0.2 * k],
            [-1, 0.2 * k, -0.1 * k],
            [-1 + 0.3 * k, 0.5 * k, 0.1 * k],
            place=(0.0, 0.0, 1.0),
        )
        for k in np.linspace(0.0, 6.0, 10)
    ]
    folder = tmp_path_factory.mktemp("proportions") / "tall"
    write_depth_recording(folder, body_model(TALL, BodyParameters()), poses)
    return folder


def test_lengths_are_printed_and_written_as_a_subject_file(folder, tmp_path, capsys):
    written = tmp_path / "subject.toml"
    status = main(["proportions", str(folder), "-o", str(written), "--json", *QUICK])
    assert status == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] >= 6
    assert abs(told["lengths_m"]["upper_arm_length"] - TALL.upper_arm_length) < 0.02
    assert 0 < told["sigma_m"]["upper_arm_length"] < 0.05
    subject = read_subject(written)
    assert subject.upper_arm_length == pytest.approx(told["lengths_m"]["upper_arm_length"])


@pytest.mark.parametrize(
    ("more", "word"),
    [
        (["--frames", "0:2"], "elbows"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(folder, capsys, more, word):
    assert main(["proportions", str(folder), *more, *QUICK]) == 2
    assert word in capsys.readouterr().err
