"""What annotating by exception takes, and how good the reference is: a scripted annotator.

It sees every landmark in every view within a pixel or so and goes from frame to frame as a person
does in the window. What is proposed as certain and lies farther off than :data:`NOTICED` is
dragged, the worst first; the rest is accepted by one key. Then it walks through what is doubtful:
Enter where the proposal is right, a click elsewhere. The reference is fitted to the clicks alone.

``python benchmarks/annotator.py RECORDING ... --frames 40:100 --seeds 1,2``
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise
from typing import TypeAlias

import numpy as np

from benchmarks.common import ended, parser_of, put_table, recordings_of
from stereotrack_core.annotation.click import ACCEPTED, Click, ClickKey, Prediction
from stereotrack_core.annotation.detected_body import body_predictions, told_once
from stereotrack_core.annotation.fit.fit import FitRequest, fit_reference
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.follow_body import BodyStep, FollowedBody, follow_body
from stereotrack_core.annotation.landmark_filter import ProposalQuestion
from stereotrack_core.annotation.predict import pixel_scale
from stereotrack_core.annotation.propose import Proposals, Proposer, acceptable
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.evaluation.summary import truth_of
from stereotrack_core.pose_model.detect import detect_keypoints
from stereotrack_core.pose_model.detector import required_detector
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader, reference_pictures
from stereotrack_core.recording.selection import frames_within, seeds_of
from stereotrack_core.tables import number

EYE = 1.0  # pixels per axis at 480 lines, to which the annotator sees a landmark
NOTICED = 3.0  # pixels at 480 lines by which a proposal must be off to be corrected
HERTZ = 10.0  # annotated frames per second
KEY_SECONDS, CLICK_SECONDS = 0.4, 1.1  # of a keystroke, and of pointing with the mouse (KLM)
_AROUND, _CHAIN = 10, 4  # clicked frames that the window makes proposals of, and follows from

Detections: TypeAlias = Mapping[int, tuple[Prediction, ...]]  # by frame


@dataclass
class Session:
    """What somebody has done so far."""

    clicks: dict[ClickKey, Click] = field(default_factory=dict)
    steps: dict[tuple[int, int], BodyStep | None] = field(default_factory=dict)
    by_hand: int = 0
    keys: int = 0
    right: list[bool] = field(default_factory=list)  # accepted as they were proposed

    def put(self, key: ClickKey, place: Sequence[float] | FloatArray, origin: str = "hand") -> None:
        """Place a landmark; by hand it is a click."""
        self.clicks[key] = Click(*key, (float(place[0]), float(place[1])), origin=origin)
        self.by_hand += origin != ACCEPTED

    def correct(self, key: ClickKey, place: FloatArray) -> None:
        """Place what is proposed elsewhere."""
        self.put(key, place)
        self.right.append(False)

    def take(self, predictions: Sequence[Prediction]) -> None:
        """Accept with one key."""
        for one in predictions:
            self.put(one.key, one.position, ACCEPTED)
        self.keys += bool(predictions)
        self.right += [True] * len(predictions)


class Annotator:
    """Annotates one recording with eyes of their own."""

    def __init__(
        self, recording: Recording, frames: Sequence[int], seed: int, detected: Detections
    ) -> None:
        self.detected, truth = detected, truth_of(recording)
        self.recording, self.frames = recording, [k for k in frames if k in truth.frame]
        names = [recording.reference_camera(view).name for view in recording.views]
        self.cameras = {name: recording.cameras[name] for name in names}
        self.sigma = dict.fromkeys(LANDMARKS, EYE)  # as blind repeats would measure it
        self.points = dict(zip(truth.frame.tolist(), truth.points, strict=True))
        rng, self.sees = np.random.default_rng(seed), dict[ClickKey, FloatArray]()
        for frame in self.frames:
            for name, camera in self.cameras.items():
                blur = EYE * pixel_scale(camera) * rng.normal(size=(len(LANDMARKS), 2))
                seen = camera.project(self.points[frame]) + blur
                for landmark, place in zip(LANDMARKS, seen, strict=True):
                    self.sees[ClickKey(frame, name, landmark)] = place

    def off(self, one: Prediction) -> float:
        """Pixels at 480 lines by which a proposal is off."""
        away = np.linalg.norm(np.array(one.position) - self.sees[one.key])
        return float(away) / pixel_scale(self.cameras[one.camera])

    def annotate(self, reader: FrameReader, proposer: Proposer | None) -> Session:
        """Go through all frames; without a proposer, everything is clicked."""
        done = Session()
        for frame in self.frames:
            if proposer is not None:
                self._by_exception(frame, reader, proposer, done)
            for key, place in self.sees.items():
                if key.frame == frame and key not in done.clicks:
                    done.put(key, place)
        return done

    def _by_exception(
        self, frame: int, reader: FrameReader, proposer: Proposer, done: Session
    ) -> None:
        known = [one for one in self.frames if one < frame][-_AROUND:]
        around = tuple(one for one in done.clicks.values() if one.frame in known)
        steps = tuple(self._steps(frame, known, around, reader, done))
        detected, fps = self.detected.get(frame, ()), self.recording.fps
        question = ProposalQuestion(
            frame, (), around, detected, self.cameras, LANDMARKS, fps, self.sigma, steps=steps
        )

        def proposed() -> Proposals:
            own = tuple(one for one in done.clicks.values() if one.frame == frame)
            return proposer(replace(question, clicks=own))

        def sure() -> tuple[Prediction, ...]:
            now = proposed()
            asked = {one.key for one in now.doubtful(self.cameras)}
            free = [one for one in now.predictions if one.key not in asked]
            return acceptable(free, around, self.cameras).predictions

        while (worst := max(sure(), key=self.off, default=None)) and self.off(worst) > NOTICED:
            done.correct(worst.key, self.sees[worst.key])
        done.take(sure())
        while left := proposed().doubtful(self.cameras):
            if self.off(left[0]) <= NOTICED:
                done.take(left[:1])
            else:
                done.correct(left[0].key, self.sees[left[0].key])
        done.take(sure())

    def _steps(
        self,
        frame: int,
        known: Sequence[int],
        clicks: tuple[Click, ...],
        reader: FrameReader,
        done: Session,
    ) -> Iterator[BodyStep]:
        body = FollowedBody(self.cameras, proportions_of(self.recording.subject))
        for pair in pairwise((*known[-_CHAIN:], frame)):
            if pair not in done.steps:
                done.steps[pair] = follow_body(reader, clicks, *pair, body=body)
            if (step := done.steps[pair]) is not None:
                yield step


def measured(annotator: Annotator, done: Session) -> tuple[float, ...]:
    """Clicks, keys and seconds a frame, share right at once, errors of the reference in mm.

    The errors are the mean distance, its root mean square, and the stated root mean square.
    """
    frames, count = annotator.frames, len(annotator.frames)
    every, settings = range(frames[0], frames[-1] + 1), FitSettings(use_depth=False)
    request = FitRequest(every, settings=settings, sigma=annotator.sigma)
    fit = fit_reference(annotator.recording, [*done.clicks.values()], request)
    rows = np.isin(fit.frame, frames)
    truth = np.array([annotator.points[k] for k in frames])
    off = 1000.0 * np.linalg.norm(fit.landmarks[rows] - truth, axis=-1)
    stated = 1000.0 * np.sqrt(np.trace(fit.covariance[rows], axis1=-2, axis2=-1))
    by_hand, keys = done.by_hand / count, done.keys / count
    right = 100.0 * float(np.mean(done.right)) if done.right else np.nan
    errors = np.nanmean(off), np.sqrt(np.nanmean(off**2)), np.sqrt(np.nanmean(stated**2))
    return by_hand, keys, KEY_SECONDS * keys + CLICK_SECONDS * by_hand, right, *map(float, errors)


def detections_of(recording: Recording, frames: Sequence[int]) -> Detections:
    """What the installed pose detector sees in some frames."""
    every = range(frames[0], frames[-1] + 1, frames[1] - frames[0])
    with FrameReader(reference_pictures(recording)) as reader:
        seen = detect_keypoints(reader, required_detector(), every)
    cameras = {one.image.camera: recording.cameras[one.image.camera] for one in recording.views}
    body = body_predictions(seen, LANDMARKS, cameras, proportions_of(recording.subject))
    return {k: tuple(own) for k, own in groupby(told_once(body), lambda one: one.frame)}


def main(arguments: Sequence[str] | None = None) -> None:
    """Annotate recordings with and without proposals, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--seeds", default="1", help="comma-separated")
    parser.add_argument("--detector", action="store_true", help="look with the pose detector")
    parser.add_argument("--frames", help="A:B, half-open (default: all)")
    args = parser.parse_args(arguments)
    rows = []
    for recording in recordings_of(args):
        with FrameReader(recording, read_ahead=0) as reader:
            asked = frames_within(args.frames, reader.frame_count)
            frames = asked[:: max(1, round(recording.fps / HERTZ))]
            detected = detections_of(recording, frames) if args.detector else {}
            for seed in seeds_of(args.seeds):
                for name, proposer in (("clicked", None), ("by exception", Proposer())):
                    annotator = Annotator(recording, frames, seed, detected)
                    found = measured(annotator, annotator.annotate(reader, proposer))
                    rows.append((recording.name, f"{name}, seed {seed}", *map(number, found)))
    put_table(
        "Annotating",
        (
            *("recording", "how", ">clicks a frame", ">keys", ">seconds", ">right at once %"),
            *(">joints mm", ">joints rms mm", ">stated rms mm"),
        ),
        rows,
    )


if __name__ == "__main__":
    sys.exit(ended(main))
