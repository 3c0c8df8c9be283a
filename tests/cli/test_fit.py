"""``stereotrack fit``: from a file of clicks to a reference, and one sentence on what is wrong."""

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.summary import errors_against
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.reference_npz import read_reference
from stereotrack_core.interop.run_file import read_run, read_trajectory
from stereotrack_core.recording.description import read_subject
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.conftest import FAST


@pytest.fixture(scope="module")
def clicks(recording, tmp_path_factory):
    """Every third frame clicked in both views; one click is far off."""
    opened, rng = open_recording(recording), np.random.default_rng(0)
    made = []
    for k in range(0, 10, 3):
        for view in opened.views:
            camera = opened.reference_camera(view)
            pixels = camera.project(opened.reference.points[k]) + rng.normal(0, 0.7, (9, 2))
            for name, (x, y) in zip(LANDMARKS, pixels, strict=True):
                wrong = (k, view.name, name) == (3, "N", "left_hand")
                made.append(Click(k, camera.name, name, (float(x), float(y) - 40.0 * wrong)))
    path = tmp_path_factory.mktemp("clicks") / "clicks.csv"
    write_clicks(path, made, opened)
    return path


def fit(run, recording, clicks, output, *more, status=0):
    words = ("fit", recording, "--clicks", clicks, "-o", output, "--sigma", 1, *more)
    return run(*words, status=status)


@pytest.mark.parametrize(("depth", "worst"), [((), 12.0), (("--without-depth",), 8.0)])
def test_fit_writes_a_reference(run, recording, clicks, tmp_path, depth, worst):
    ended = fit(run, recording, clicks, tmp_path / "reference.npz", "--json", *depth)
    assert ended.json["frames"] == {"clicked": 4, "interpolated": 6, "gap": 0}
    assert ended.json["clicks"] == 72
    assert set(ended.json["limb_sigma_deg"]) == set(LIMBS)
    (outlier,) = ended.json["probable_outliers"]
    assert (outlier["frame"], outlier["landmark"]) == (3, "left_hand")
    found = read_reference(tmp_path / "reference.npz").trajectory()
    assert found.frame.tolist() == list(range(10))
    errors = errors_against(found, open_recording(recording).reference)
    errors = errors.between(0, 1)  # clicked: without depth, the others are not sure enough
    assert np.degrees(errors.forearm).mean() < worst
    assert np.degrees(errors.upper_arm).mean() < worst


def test_npz_keeps_the_covariances(run, recording, clicks, tmp_path):
    options = ("--without-depth", "--frames", "2:8")
    ended = fit(run, recording, clicks, tmp_path / "a.npz", *options)
    assert "probable outlier" in ended.err
    assert "uncertainty left forearm" in ended.out
    stored = read_reference(tmp_path / "a.npz")
    assert stored.frame.tolist() == [2, 3, 4, 5, 6, 7]
    assert stored.covariance.shape == (6, 9, 3, 3)
    assert np.isfinite(stored.covariance).all()
    assert stored.filled.tolist() == [True, False, True, True, False, True]
    assert stored.meta["click_sigma_px"] == 1
    angles = run("evaluate", tmp_path / "a.npz", "--angles", "--json").json["angles"]
    assert angles["frames_per_second"] == 10.0
    run("export", tmp_path / "a.npz", "--format", "trc", "-o", tmp_path / "a.trc")
    assert read_trajectory(tmp_path / "a.trc").fps == 10.0


def test_what_is_wrong_is_said_in_one_sentence(run, recording, clicks, tmp_path):
    output = tmp_path / "a.csv"
    empty = tmp_path / "empty.csv"
    empty.write_text("frame,view,landmark,x,y,visibility\n")
    for options, said in (
        (("--sigma", "-1"), "above 0"),
        (("--frames", "1:2"), "no click in frames 1 to 1"),
        (("--views", "X"), "no view"),
    ):
        ended = fit(run, recording, clicks, output, *options, status=2)
        assert ended.out == ""
        assert said in ended.err
    for path, target in ((empty, output), (tmp_path / "none.csv", output), (clicks, "a.txt")):
        fit(run, recording, path, target, status=2)
    assert not output.exists()


def test_a_few_clicked_frames_make_a_subject_file(run, recording, tracked, clicks, tmp_path):
    written = tmp_path / "subject.toml"
    ended = fit(run, recording, clicks, written, "--personalise", "--run", tracked, "--json")
    frames = ended.json["frames"]
    assert frames
    assert set(frames) <= {0, 3, 6, 9}
    assert set(ended.json["offsets_m"]) == set(LANDMARKS)
    sigma = np.array(list(ended.json["sigma_m"].values()))
    assert (sigma > 0.0).all()
    assert (sigma < 0.011).all()
    subject = read_subject(written)
    own = open_recording(recording).subject
    assert subject.torso_length == pytest.approx(own.torso_length)
    for name, offset in subject.offsets.items():
        assert offset == pytest.approx(tuple(ended.json["offsets_m"][name]), abs=1e-5)
    told = fit(run, recording, clicks, written, "--personalise", "--run", tracked)
    assert f"Offsets from {len(frames)} clicked frames, mm" in told.out
    refused = fit(run, recording, clicks, tmp_path / "subject.csv", "--personalise", status=2)
    assert ".toml" in refused.err


def test_clicks_are_measurements_of_a_run(run, recording, clicks, tmp_path):
    settings = (*FAST, "--frames", "0:4", "--clicks", clicks, "--json")
    ended = run("track", recording, "-o", tmp_path / "run.npz", *settings)
    assert set(ended.json["repaired"]) <= {1, 2}  # between the clicked frames
    first = read_run(tmp_path / "run.npz")
    assert first.meta["clicks"]["count"] == 72
    run("track", recording, "-o", tmp_path / "b.npz", "--like", tmp_path / "run.npz")
    second = read_run(tmp_path / "b.npz")
    assert second.meta["clicks"] == first.meta["clicks"]
    np.testing.assert_array_equal(second.landmarks, first.landmarks)
    thesis = ("-o", tmp_path / "c.npz", "--clicks", clicks, "--preset", "thesis")
    refused = run("track", recording, *thesis, status=2)
    assert "does not use clicks" in refused.err
