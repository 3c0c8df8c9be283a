"""What to track of a recording, and how: all that decides how a run comes out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.keypoints import Keypoints, of_one_person
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.tracking.parameters import Settings

# ``"auto"``: found without help; ``"auto 90"``: the same of somebody who faces so many degrees from
# north over east; ``"tpose"``: the T pose facing north; or a pose.
FirstPose: TypeAlias = str | Pose
AUTO = "auto"


def is_found(init: FirstPose) -> bool:
    """Whether a first pose is looked for."""
    return isinstance(init, str) and init.split(" ")[0] == AUTO


def given_heading(init: FirstPose) -> float | None:
    """Degrees from north over east that somebody faces whose first pose is looked for."""
    if isinstance(init, str) and is_found(init) and " " in init:
        return float(init.split(" ")[1])
    return None


@dataclass(frozen=True, eq=False)
class RunSpec:
    """Everything that a run depends on besides its recording and the program's version.

    Examples
    --------
    >>> spec = RunSpec(preset("accurate"), frames=range(40), views=["N", "S"], seed=1)
    >>> run = track(open_recording(Path("recording")), spec)
    """

    settings: Settings
    preset: str = ""  # name of the preset that they were made from, for the run's description
    frames: range | None = None  # Half-open; None: all
    views: Sequence[str] | None = None
    """None: all that give depth; where none does, those with keypoints."""
    seed: int = 0  # of all that is random
    init: FirstPose = AUTO  # first pose
    smooth: bool = False  # whether the frames are gone over backwards as well
    keypoints: Keypoints | None = None  # of one person, as a 2-D detector has predicted them
    clicks: Detections | None = None
    """Landmarks that a person clicked, whose kinds are the nine landmarks."""
    colour: bool | None = None
    """Whether pictures are read in colour; None: as the parameters need it."""
    detector: bool = True
    """Whether the installed pose detector may look at pictures; a run without it is repeated so."""
    seen: Mapping[int, Keypoints] | None = None
    """By frame, what the detector saw in an earlier run; these frames are not looked at again."""

    @cached_property
    def used_keypoints(self) -> Keypoints | None:
        """Rows of `keypoints` that tracking reads: of one person in the frames to track."""
        if self.keypoints is None or self.frames is None:
            return self.keypoints
        return of_one_person(self.keypoints).of_frames(self.frames)

    def frames_of(self, count: int) -> range:
        """Frames to track of a recording that has so many."""
        return range(count) if self.frames is None else self.frames


@dataclass(frozen=True, eq=False)
class Hooks:
    """Functions that a run calls on its way; each may raise :class:`Cancelled`."""

    # told a stage in words, done, count; in any thread
    on_preparing: Callable[[str, int, int], None] = lambda _stage, _done, _count: None
    before_step: Callable[[], None] = lambda: None  # called before each step
    cancelled: Callable[[], bool] = lambda: False  # asked after every frame whether to stop

    @classmethod
    def asking(cls, cancelled: Callable[[], bool]) -> Hooks:
        """Hooks that raise :class:`Cancelled` once somebody wants it."""

        def ask(*_: object) -> None:
            if cancelled():
                raise Cancelled

        return cls(on_preparing=ask, before_step=ask)


def measured_keypoints(
    recording: Recording, settings: Settings, keypoints: Keypoints | None
) -> Keypoints | None:
    """Keypoints that a run is given: none beside a cloud whose tracker does not measure any."""
    return keypoints if settings.follows_data or not gives_depth(recording) else None
