"""Small valid files of every format that is read."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Segment, Stream, Subject, View
from stereotrack_core.recording.keypoint_names import LAYOUTS
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.versions import versions
from tests.evaluation.failure_segments.runs import made

WIDTH, HEIGHT, FRAMES = 48, 36, 6
SUBJECT = Subject("P", shoulder_width=0.4, torso_length=0.5)


@dataclass(frozen=True)
class Samples:
    """A recording folder in which nothing is wrong, and what belongs to it."""

    recording: Recording
    run: Run
    reference: Reference
    clicks: tuple[Click, ...]

    @property
    def seen_clicks(self) -> tuple[Click, ...]:
        """Those of the clicks that have a place."""
        return tuple(click for click in self.clicks if click.position is not None)

    @property
    def keypoints(self) -> Keypoints:
        """What a detector might say of one camera."""
        names = LAYOUTS["body25"][:4]
        rows = ((k, "S", name, 3.0 + k, 7.5, 0.5, "x", 0) for k in range(3) for name in names)
        return keypoints_of(rows)

    @property
    def picture(self) -> np.ndarray:
        """Noise, which nothing makes smaller."""
        return np.random.default_rng(1).integers(0, 256, (96, 128), dtype=np.uint8)


def made_samples(folder: Path) -> Samples:
    """Make the recording in `folder`, and in memory the rest."""
    rng = np.random.default_rng(5)
    lens = np.array([[40.0, 0, 23.5], [0, 40, 17.5], [0, 0, 1]])
    ahead = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    cameras = {
        name: Camera(name, WIDTH, HEIGHT, lens, np.zeros(5), False,
                     RigidTransform(ahead, np.array([aside, 1.2, 3.0])))
        for name, aside in (("N_left", 0.1), ("N_right", 0.0), ("O", 0.5), ("S", -0.5))
    }  # fmt: skip
    for name in (*cameras, "O_depth"):
        (folder / name).mkdir()
        for k in range(2):
            kind = np.uint16 if name == "O_depth" else np.uint8
            picture = rng.integers(0, 200, (HEIGHT, WIDTH)).astype(kind)
            write_png(folder / name / f"{k:03d}.png", picture)
    left, right, image, mono = (
        Stream(name, f"{name}/%03d.png", f"{name}/000.png", first_frame=1, time_offset=-0.1)
        for name in cameras
    )
    views = (
        View("N", "stereo", right, left=left),
        View("O", "depth", image, depth=Stream("O", "O_depth/%03d.png"),
             mask=Stream("", "O/%03d.png")),
        View("S", "mono", mono, display_rotation=90),
    )  # fmt: skip
    run = made_run(folder)
    recording = Recording(
        folder, "small", 10.0, views, cameras, SUBJECT,
        LandmarkTrajectory(run.frame, run.landmarks), (Segment("first", 0, 4), Segment("b", 4, 6)),
    )  # fmt: skip
    write_recording_description(recording)
    reference = Reference(
        run.frame, run.landmarks, np.tile(1e-4 * np.eye(3), (FRAMES, 9, 1, 1)),
        run.limb_sigma_deg, np.zeros(FRAMES, dtype=bool),
        meta={"fps": 10.0, "sigma_factor": 1.0, "outliers": [[0, "S", "head", 0.5]]},
    )  # fmt: skip
    return Samples(recording, run, reference, made_clicks())


def made_run(folder: Path) -> Run:
    """A run of a person who stands still, and states everything that runs state."""
    meta = {
        "program": "stereotrack", "version": "0.1.0", "preset": "accurate",
        "parameters": Settings().values(), "body": BodyShape().values(), "seed": 0,
        "views": ["N", "O"], "init": "pose", "fps": 10.0, "recording": "small",
        "recording_folder": str(folder), "fingerprint": "0" * 32,
        "subject": dataclasses.asdict(SUBJECT), "smoothed": False, "bridged": [],
        "first_pose": {"position": [0.0, 0.0, 1.0], "rotations": [np.eye(3).tolist()] * len(PARTS)},
        "frames": [0, FRAMES], "colour": False, "calibration": "1" * 32, "versions": versions(),
        "detections": {"source": "detections.csv", "fingerprint": "2" * 32, "count": 3},
        "made": "2026-06-11T10:00:00+00:00", "wall_seconds": 1.5,
        "blind": [{"view": "N", "first": 1, "end": 3, "reason": "dark"}],
        "started_at_reference": [0, 5],
    }  # fmt: skip
    own = {"limb_lost": np.full((FRAMES, 6), 0.1), "seconds": np.zeros((FRAMES, 2))}
    return made(FRAMES, **own, stage_names=("match", "filter"), meta=meta)[0]


def made_clicks() -> tuple[Click, ...]:
    """Some of every kind."""
    return tuple(
        Click(frame, "S", name, None if k == 3 else (k + 1.5, 7.25), Visibility(0 if k == 3 else 2))
        for frame in range(4)
        for k, name in enumerate(NINE.names[:5])
    )


def made_video(path: Path, codec: str, pixels: str, options: dict[str, str] | None = None) -> bytes:
    """A short video, the same on every machine; its bytes."""
    rng = np.random.default_rng(7)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=10)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, pixels
        stream.options, stream.thread_count = options or {}, 1
        for _ in range(FRAMES):
            grey = rng.integers(30, 220, (HEIGHT, WIDTH)).astype(np.uint8)
            frame = av.VideoFrame.from_ndarray(grey, format="gray").reformat(format=pixels)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path.read_bytes()
