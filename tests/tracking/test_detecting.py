"""The pose detector beside the tracker."""

import dataclasses
from contextlib import closing

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth import mono_silhouettes
from stereotrack_core.geometry.upright import Z_UP
from stereotrack_core.interop.run_journal import RunJournal, read_unfinished
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.pose_model.crops import Crop
from stereotrack_core.pose_model.detector import POINT_NAMES, DetectedPose
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking import detecting
from stereotrack_core.tracking.clouds import Clouds, chain_of
from stereotrack_core.tracking.detecting import SeenKeypoints, seen_in_views, without_outliers
from stereotrack_core.tracking.frame import DETECTED_SCENES
from stereotrack_core.tracking.repeating import other_files, stored_spec
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.trial import Trial
from tests.same_run import same_run
from tests.tracking.keypoints.cases import VIEWS
from tests.tracking.recordings import SMALL, write_depth_recording
from tests.tracking.scenes import cloud_of, pose_with_arms


class Detector:
    """Sees 33 points around the middle of the crop, if anybody is there; some anywhere else."""

    def __init__(self):
        self.score, self.asked, self.gross = 0.9, 0, []

    def landmarks(self, picture, crop):
        self.asked += 1
        points = crop.centre + np.linspace(-6.0, 6.0, 66).reshape(33, 2)
        rng = np.random.default_rng(self.asked)
        height, width = picture.shape
        points[self.gross] = rng.uniform(0, [width - 1, height - 1], (len(self.gross), 2))
        circle = np.array([crop.centre, crop.centre - [0.0, 0.4 * crop.side]])
        sure = np.full(33, 0.8)
        return DetectedPose(points, sure, sure, self.score, circle)


@pytest.fixture
def detector(monkeypatch):
    one = Detector()
    monkeypatch.setattr(detecting, "load_detector", lambda: one)
    return one


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    poses = [
        pose_with_arms([1, 0.1 * k, 0], [1, 0, 0], [-1, 0, 0], [-1, 0, 0.1 * k], place=(0, 0, 0.95))
        for k in range(5)
    ]
    folder = tmp_path_factory.mktemp("recording") / "cones"
    return write_depth_recording(folder, body_model(AVERAGE, SMALL.body), poses)


def spec(**changes):
    return RunSpec(SMALL.replaced(**changes), preset="fast", seed=3)


@pytest.fixture(scope="module")
def seen_cloud(recording):
    with Clouds(recording, spec(detector="off")) as clouds, FrameReader(recording) as reader:
        clouds.learn(range(5), Hooks())
        yield reader, clouds.take(0)[0]


def seen_of(recording, detector, seen_cloud):
    """What is used, and what is kept, of the frame."""
    reader, cloud = seen_cloud
    looks = SeenKeypoints(detector, recording, [v.name for v in recording.views], reader, Z_UP)
    return looks.of(cloud, 0), looks.seen(0)


def test_keypoints_beside_the_person_are_not_used_and_stay_in_the_run(
    recording, detector, seen_cloud
):
    name = POINT_NAMES.index("left_shoulder")
    right = seen_of(recording, detector, seen_cloud)[0]
    detector.gross = [name]
    used, kept = seen_of(recording, detector, seen_cloud)
    assert len(kept) == 4 * 33
    out = kept.keypoint[kept.confidence == 0.0].tolist()
    assert len(out) >= 3
    assert set(out) == {"left_shoulder"}
    assert used.count == right.count - len(out)


def test_a_run_says_that_keypoints_were_not_used(recording, detector):
    detector.gross = list(range(0, 33, 2))
    run, without = track(recording, spec()), track(recording, spec(detector="off"))
    [*_, said] = run.meta["warnings"]
    assert "2 of the 2 images of camera" in said
    apart = np.linalg.norm(run.landmarks - without.landmarks, axis=2)
    assert np.nanmax(apart) < 0.02


def test_a_run_states_the_detector_and_is_repeated_with_or_without_it(recording, detector):
    run, without = track(recording, spec()), track(recording, spec(detector="off"))
    assert detector.asked == 8
    assert (run.meta["detector"], without.meta["detector"]) == ("blazepose", "")
    assert (run.x != without.x).any()
    assert same_run(without, track(recording, stored_spec(without).spec))
    [missing] = other_files(dataclasses.replace(run, keypoints=None), recording)
    assert "detector install" in missing
    assert other_files(run, recording) == other_files(without, recording) == ()
    scenes = dataclasses.replace(without, meta={**without.meta, DETECTED_SCENES: ["N"]})
    assert other_files(scenes, recording) == (missing,)
    made = [stored_spec(one).spec.detector for one in (run, without, scenes)]
    assert made == [True, False, True]


def test_a_run_holds_what_was_seen_and_is_repeated_without_the_detector(
    recording, detector, monkeypatch, tmp_path
):
    run = track(recording, spec())
    assert np.bincount(run.keypoints.frame).tolist() == [4 * 33, 0, 0, 0, 4 * 33]
    write_npz(tmp_path / "run.npz", run)
    stored = read_npz(tmp_path / "run.npz")
    assert stored.keypoints.fingerprint() == run.keypoints.fingerprint()
    monkeypatch.setattr(detecting, "load_detector", lambda: None)
    again = track(recording, stored_spec(stored).spec)
    assert same_run(run, again)
    assert again.keypoints.fingerprint() == run.keypoints.fingerprint()
    assert again.meta["detector"] == "blazepose"


def test_frames_of_a_run_that_goes_on_are_not_looked_at_again(recording, detector, tmp_path):
    path, states = tmp_path / "run.part", []
    journal = RunJournal(path, lambda: 1.0)

    def keep(advance):
        journal.keep(advance)
        states.append(path.read_bytes())

    whole = track(recording, spec(), on_advance=keep)
    journal.close()
    path.write_bytes(states[2])
    begun, _ = read_unfinished(path)
    assert begun.run().keypoints.frame.tolist() == [0] * 4 * 33
    detector.asked = 0
    assert same_run(whole, track(recording, spec(), begun=begun))
    assert detector.asked == 4


@pytest.mark.parametrize(("wish", "expected"), [("auto", True), ("off", False)])
def test_a_run_and_a_trial_have_silhouettes_of_plain_videos_where_the_detector_is_wanted(
    wish, expected, recording, monkeypatch
):
    monkeypatch.setattr(mono_silhouettes, "load_detector", Detector)
    monkeypatch.setattr(mono_silhouettes.MonoSilhouettes, "learn", lambda *_: None)
    views = [dataclasses.replace(view, kind="mono", depth=None) for view in recording.views]
    mono = dataclasses.replace(recording, views=tuple(views))
    names, wanted = [view.name for view in views], spec(detector=wish)
    with FrameReader(recording) as reader, closing(CloudStore(mono, reader, mono=names)) as store:
        assert bool(chain_of(mono, wanted, names, reader)[0].silhouettes) == expected
        repeated = dataclasses.replace(wanted, detector=False)  # the run before had no detector
        assert not chain_of(mono, repeated, names, reader)[0].silhouettes
        assert bool(store.chain(Trial(wanted).key).silhouettes) == expected


def _rows(camera, places, confidence=0.9):
    return [(0, camera, name, *at, confidence, "x", 0) for name, at in places.items()]


def test_keypoints_are_kept_that_lie_on_the_person_of_the_cloud(rng):
    camera, points = VIEWS["N"], rng.normal([0.0, 0.0, 1.2], [0.2, 0.1, 0.4], (60, 3))
    points[:5] += [0.0, 9.0, 0.0]  # behind the camera
    pixels, depth = camera.project(points[5:]), camera.camera_from_world.apply(points[5:])[:, 2]
    focal = camera.matrix[0, 0]
    for few, off in ((False, 0.11), (True, 0.13)):
        names = [f"k{k}" for k in range(10)] + ["left_heel"]
        places = [pixels[5 * k] + [1.5 * rng.random(), 0.0] for k in range(7)]
        places += [pixels[0] + [300.0, 0.0]] * 3 + [pixels[0] + [400.0, 0.0]]
        far = np.array([0.0, 1.0]) * off * focal / depth[pixels[:, 1].argmax()]
        places[6] = pixels[pixels[:, 1].argmax()] + far
        beside = [min(np.linalg.norm(at - pixels, axis=1) * depth) / focal for at in places]
        rows = keypoints_of(_rows("N", dict(zip(names, places, strict=True))))
        seen = without_outliers(rows, cloud_of(points), {"N": camera, "S": VIEWS["S"]})
        near = [one < 0.12 for one in beside[:10]]
        assert (np.mean(near) < 0.7) == few
        kept = [not few and one <= 0.3 for one in beside[:10]] + [not few]
        used = dict(zip(seen.keypoint.tolist(), seen.confidence > 0.0, strict=True))
        assert used == dict(zip(names, kept, strict=True))


@pytest.mark.parametrize(("off", "kept"), [(0.29, True), (0.31, False)])
def test_a_keypoint_30_cm_beside_the_person_is_somebody_else_s(off, kept):
    camera, points = VIEWS["N"], np.array([[0.0, 0.0, 1.2]])
    pixel, depth = camera.project(points)[0], camera.camera_from_world.apply(points)[0, 2]
    places = {f"k{k}": pixel for k in range(9)}
    places["out"] = pixel + [off * camera.matrix[0, 0] / depth, 0.0]
    seen = without_outliers(keypoints_of(_rows("N", places)), cloud_of(points), {"N": camera})
    assert dict(zip(seen.keypoint, seen.confidence, strict=True))["out"] == (0.9 if kept else 0.0)
    behind = without_outliers(seen, cloud_of(points + [0.0, 9.0, 0.0]), {"N": camera})
    assert not behind.confidence.any()


@pytest.mark.parametrize(
    ("wrist", "elbow", "crossed"),
    [(9.9, 18.1, True), (10.1, 18.1, False), (9.9, 17.9, False)],
)
def test_arms_may_be_crossed_by_the_widths_of_wrists_and_elbows(recording, wrist, elbow, crossed):
    off = {"shoulder": 20.0, "elbow": elbow, "wrist": wrist}
    camera = recording.views[0].image.camera
    places = {f"left_{name}": (80.0 - 0.5 * x, 60.0) for name, x in off.items()}
    places |= {f"right_{name}": (80.0 + 0.5 * x, 60.0) for name, x in off.items()}
    rows = keypoints_of(_rows(camera, places))
    assert seen_in_views(recording, [recording.views[0].name], rows).crossed == crossed


def test_arms_are_trusted_half_and_a_second_look_is_taken_a_quarter_beside():
    arm = [name.split("_")[-1] in ("elbow", "wrist", "hand") for name in POINT_NAMES]
    np.testing.assert_array_equal(detecting._TRUST, np.where(arm, 0.5, 1.0))
    for beside, looks in ((0.24, 1), (0.26, 2)):
        asked = []

        class Shifted:
            def landmarks(self, picture, crop, asked=asked, beside=beside):
                asked.append(crop)
                hips = crop.centre + [10.0 * beside, 0.0]
                circle = np.array([hips, hips + [0.0, 10.0]])
                sure, places = np.ones(33), np.zeros((33, 3))
                return DetectedPose(places[:, :2], sure, sure, 0.9, circle, places)

        crop = Crop(np.array([50.0, 40.0]), 60.0, 0.0)
        assert detecting._pose_in(Shifted(), np.zeros((80, 100), np.uint8), crop) is not None
        assert len(asked) == looks
