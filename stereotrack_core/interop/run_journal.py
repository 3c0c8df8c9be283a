"""A run that is written frame by frame while it is tracked, in a file ``RUN.part``.

However tracking ends, killed, too, every frame that was tracked is in it. It can be read like a run
file, and ``stereotrack track --resume`` goes on with it.
"""

from collections.abc import Callable
from dataclasses import astuple, dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.depth.cloud import PointCounts
from stereotrack_core.errors import InputError
from stereotrack_core.interop.records import Record, RecordFile, read_records
from stereotrack_core.reading import decoding
from stereotrack_core.recording.keypoints import Keypoints, columns_of, keypoints_of_columns
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tables import LARGEST as LAST_FRAME
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.frame import Origin, TrackedFrame, cloudless
from stereotrack_core.tracking.run import Advance
from stereotrack_core.tracking.stored import check_meta
from stereotrack_core.tracking.unfinished import Checkpoint, UnfinishedRun

PART_SUFFIX = ".part"

_MAGIC = b"strun 1\n"
_HEAD, _FRAME, _TRACKER = "head", "fram", "trac"

_FOREIGN = "this is not an unfinished run of this program, or its beginning is damaged"
_REMEDY = f"Use a {PART_SUFFIX} file written by `stereotrack track`, or move it away."

_KEYPOINT = "keypoint_"

_LARGEST = 1e9  # beyond it a number is no person's, and cannot be computed with
_FRAMES_PER_CHECKPOINT = 20
"""How many frames are tracked again at most where a run goes on. What the tracker remembers takes
three times as much room as a frame."""


def part_of(run: Path) -> Path:
    """Where the frames of a run are kept until it is complete."""
    return run.with_name(run.name + PART_SUFFIX)


@dataclass(frozen=True)
class Wish:
    """What else was asked for when the run was begun: to smooth it at the end, how many frames."""

    smooth: bool = False
    count: int | None = None


class RunJournal:
    """Keeps what is tracked at once, in a new file or an unfinished run to go on with.

    `seconds`: how long has been worked on the run, for its meta. InputError where another program
    writes to the file, it holds something else, or none can be made there.
    """

    def __init__(self, path: Path, seconds: Callable[[], float], wish: Wish | None = None) -> None:
        self.path, self.kept = path, 0
        self._last = -1
        self._seconds, self._wish = seconds, wish or Wish()
        try:
            self._file = RecordFile(path, _MAGIC)
        except BlockingIOError:
            remedy = "Wait until it has finished, or choose another output."
            raise InputError("another program is writing this run", path, remedy) from None
        except ValueError:
            raise InputError(_FOREIGN, path, _REMEDY) from None
        except OSError as error:
            what = f"cannot write a file here ({error.strerror})"
            raise InputError(what, path, "Choose a folder that you may write to.") from None

    def keep(self, advance: Advance) -> None:
        """Write new frames, and at times the state; OSError where the drive is full or gone."""
        run, frames = advance.run, advance.gained.frames
        for frame in frames:
            again = frame.frame <= self._last  # not what a resumed run tracks again
            if self.kept == 0 or again:
                self._file.append(_head(run.origin(), self._wish, again=again))
                self.kept = 0
            self._file.append(_record_of(frame, self._seconds()))
            # From an earlier state tracking goes on as well, and comes to the same.
            if self.kept % _FRAMES_PER_CHECKPOINT == 0:
                facts = {"frame": frames[-1].frame, "started": run.started}
                self._file.append(Record(_TRACKER, facts, run.saved()))
            self.kept, self._last = self.kept + 1, frame.frame

    def close(self) -> None:
        """Leave the file as it is; one without any frame is removed."""
        self._file.close()
        if self.kept == 0 and not has_frames(self.path):
            self.path.unlink(missing_ok=True)

    def remove(self) -> None:
        """Remove the file: the run is kept elsewhere now."""
        self._file.close()
        self.path.unlink(missing_ok=True)


def has_frames(path: Path) -> bool:
    """Whether there is an unfinished run with at least one frame, or something that is not ours."""
    if not path.exists():
        return False
    try:
        return any(record.kind == _FRAME for record in read_records(path, _MAGIC))
    except (InputError, ValueError):
        return True


def read_unfinished(path: Path) -> tuple[UnfinishedRun, Wish]:
    """What is left of a stopped run, and what else it was to be; InputError if unreadable."""
    head: Record | None = None
    frames: dict[int, TrackedFrame] = {}
    checkpoints: dict[int, Checkpoint] = {}
    seconds, again = 0.0, False
    with decoding(path, _FOREIGN, _REMEDY):
        for record in read_records(path, _MAGIC):
            if record.kind == _HEAD:
                head, again = record, bool(record.facts.get("again"))
            elif record.kind == _FRAME:
                frame = _frame_of(record)
                if again:
                    frames = {k: one for k, one in frames.items() if k < frame.frame}
                    checkpoints = {k: one for k, one in checkpoints.items() if k < frame.frame}
                    again = False
                frames[frame.frame] = frame
                seconds = max(seconds, float(record.facts["seconds"]))
            elif record.kind == _TRACKER:
                number, started = int(record.facts["frame"]), bool(record.facts["started"])
                checkpoints[number] = Checkpoint(number, started, record.arrays)
        if head is None:
            raise ValueError("it does not state the source of the frames")
        check_meta(head.facts["meta"], f"{path}, meta", _REMEDY)
        meta, names = head.facts["meta"], tuple(str(name) for name in head.facts["state_names"])
        n, ordered = len(names), tuple(frames[k] for k in sorted(frames))
        if any(one.estimate.P.shape != (n, n) or one.x.shape != (n,) for one in ordered):
            raise ValueError("wrong state size")
        asked = range(*(int(number) for number in meta["frames"]))
        done = takewhile(frames.__contains__, asked)
        last = next((checkpoints[k] for k in reversed(list(done)) if k in checkpoints), None)
        wish = Wish(**head.facts["wish"])
        return UnfinishedRun(ordered, names, meta, seconds, last, _keypoints_in(head)), wish


def _head(origin: Origin, wish: Wish, *, again: bool) -> Record:
    """What holds for the frames after it; `again`: they take the place of those from there on."""
    facts: dict[str, Any] = {"meta": origin.meta, "state_names": origin.state_names}
    facts |= {"wish": {"smooth": wish.smooth, "count": wish.count}, "again": again}
    names, arrays = _packed(origin.spec.used_keypoints)
    return Record(_HEAD, facts | names, arrays)


def _packed(keypoints: Keypoints | None) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Facts and arrays of keypoints, which records hold without texts."""
    columns = {} if keypoints is None else columns_of(keypoints)
    names = {name: array.tolist() for name, array in columns.items() if array.dtype.kind == "U"}
    arrays = {_KEYPOINT + name: array for name, array in columns.items() if name not in names}
    return ({_KEYPOINT + "names": names} if names else {}), arrays


def _keypoints_in(record: Record) -> Keypoints | None:
    names = record.facts.get(_KEYPOINT + "names")
    if names is None:
        return None
    columns = {name: np.array(texts, dtype=np.str_) for name, texts in names.items()}
    for name, array in record.arrays.items():
        if name.startswith(_KEYPOINT):
            columns[name.removeprefix(_KEYPOINT)] = array
    return keypoints_of_columns(columns)


def _record_of(frame: TrackedFrame, seconds: float) -> Record:
    estimate, prior = frame.estimate, frame.estimate.prior
    signs = [estimate.unexplained_fraction, estimate.residual, estimate.innovation]
    facts = {
        "frame": frame.frame,
        "tracked": estimate.tracked,
        "reason": estimate.reason,
        "seconds": seconds,
        "stages": dict(frame.seconds),
        "problems": dict(frame.problems),
        "counts": {view: astuple(counts) for view, counts in frame.cloud.counts.items()},
    }
    arrays = {
        "landmarks": frame.landmarks,
        "position": estimate.pose.position,
        "rotations": estimate.pose.rotations,
        "x": estimate.x,
        "P": estimate.P,
        "signs": np.array([*signs, frame.contradicted]),
        "limb_sigma_deg": estimate.limb_sigma_deg,
        "limb_lost": estimate.limb_lost,
    }
    if prior is not None:
        arrays |= {"prior_P": prior.P, "carried": prior.carried}
    names, columns = _packed(frame.keypoints)
    return Record(_FRAME, facts | names, arrays | columns)


def _frame_of(record: Record) -> TrackedFrame:
    facts, arrays = record.facts, record.arrays
    unexplained, residual, innovation, contradicted = _shaped(arrays["signs"], 4).tolist()
    prior = None
    if "prior_P" in arrays:
        n = len(arrays["x"])
        carried = np.asarray(arrays["carried"], dtype=np.bool_).reshape(n)
        prior = Prior(_shaped(arrays["prior_P"], n, n), carried)
    estimate = Estimate(
        tracked=bool(facts["tracked"]),
        reason=str(facts["reason"]),
        pose=Pose(_shaped(arrays["position"], 3), _shaped(arrays["rotations"], len(PARTS), 3, 3)),
        x=arrays["x"],
        P=arrays["P"],
        unexplained_fraction=unexplained,
        residual=residual,
        innovation=innovation,
        limb_sigma_deg=_shaped(arrays["limb_sigma_deg"], len(LIMBS)),
        limb_lost=_shaped(arrays["limb_lost"], len(LIMBS)),
        prior=prior,
    )
    number = int(facts["frame"])
    if not 0 <= number <= LAST_FRAME:
        raise ValueError("invalid frame number")
    problems = {str(view): str(words) for view, words in facts["problems"].items()}
    stages = {str(stage): float(spent) for stage, spent in facts["stages"].items()}
    counts = {str(view): _counts(told) for view, told in facts.get("counts", {}).items()}
    landmarks = _shaped(arrays["landmarks"], len(LANDMARKS), 3)
    nothing = cloudless(number, problems, counts)
    seen = _keypoints_in(record)
    return TrackedFrame(number, estimate, landmarks, nothing, stages, contradicted, seen)


def _counts(told: list[Any]) -> PointCounts:
    # journals of older versions tell nothing of noise and blur
    middle = None if told[5] is None else tuple(map(float, told[5]))
    values: list[Any] = [*map(int, told[:5]), middle, *map(float, told[6:])]
    return PointCounts(*values)


def _shaped(array: FloatArray, *shape: int) -> FloatArray:
    if array.shape != shape or array.dtype != np.float64:
        raise ValueError("wrong array shape")
    if (np.abs(array) > _LARGEST).any():
        raise ValueError("invalid numbers in a frame")
    return array
