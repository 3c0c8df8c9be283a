"""The next clicks, ranked by the degrees that they are expected to gain, and when to stop."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey, Sigmas
from stereotrack_core.annotation.click_gains import (
    AXES,
    REACH,
    SCORED,
    ClickGains,
    Place,
    over_frames,
    shares_around,
)
from stereotrack_core.annotation.doubts import (
    Doubt,
    DoubtKind,
    angle_of_residual,
    disagreement_deg,
    doubtful_camera,
    doubts_of,
    own_outliers,
    swaps_of,
    what_disagrees,
)
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import BoolArray, FloatArray, stretches_of
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import UNKNOWN_DEG, counted, spread_words
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LandmarkTrajectory

Kind: TypeAlias = Literal["free", "unknown", "skipped", DoubtKind]
KIND_WORDS: Mapping[Kind, str] = {
    "free": "Would help most",
    "unknown": "Nothing known",
    "skipped": "Visible but skipped",
    "place": "Far from the fit",
    "appearance": "Looks different",
    "swapped": "Sides exchanged",
    "camera": "Camera disagrees",
}
"""Kinds of suggestions, as a person chooses them."""


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A place where a click would help."""

    frame: int
    camera: str
    landmark: str
    gain_deg: float
    """By how much the click is expected to bring down the angle by which the limbs of this frame
    may be off (root mean square), summed up over the limbs and the torso's cross axis; degrees."""
    reason: str  # why, in words for a person; most important first
    click_there: bool = False  # whether there is a click already that should be looked at again
    over_frames_deg: float = 0.0  # the same over all frames that profit; ranks suggestions
    clear: bool = True  # the landmark is visible, and the camera agrees with the others
    kind: Kind = "free"

    @property
    def key(self) -> ClickKey:
        """Frame, camera and landmark."""
        return ClickKey(self.frame, self.camera, self.landmark)


@dataclass(frozen=True)
class StopSign:
    """Whether the wanted accuracy is reached."""

    wanted_deg: float  # angle by which a limb may be off (root mean square), degrees
    frames: int  # frames that count
    frames_missing: int  # of them, with a limb that misses it or is unknown
    missing_by_limb: Mapping[str, int]  # frames in which that limb misses it
    allowed: float = 0.05  # share of the frames that may miss it
    frames_unknown: int = 0  # frames in which the direction of a limb is unknown
    frames_clicked: int = 0

    @property
    def reached(self) -> bool:
        """Whether to stop clicking."""
        return self.frames > 0 and self.frames_missing <= self.allowed * self.frames

    def words(self) -> str:
        """``12 of 490 frames exceed 3 deg, most often the left forearm (9)``."""
        if not self.frames:
            return "not fitted yet"
        if not self.frames_missing:
            return f"all {self.frames} frames are within {self.wanted_deg:g} deg: target reached"
        if self.frames_unknown and not self.reached:
            within = self.frames - self.frames_missing
            less = self.frames_missing - self.frames_unknown
            return (
                f"{within} of {self.frames} frames are within {self.wanted_deg:g} deg, {less} less "
                f"certain, {self.frames_unknown} have unknown limbs, too far from a click: "
                f"{counted(self.frames_clicked, 'frame')} clicked so far"
            )
        worst = max(self.missing_by_limb, key=lambda limb: self.missing_by_limb[limb])
        number = self.missing_by_limb[worst]
        text = f"{self.frames_missing} of {self.frames} frames exceed {self.wanted_deg:g} deg"
        if number:
            text += f", most often the {worst.replace('_', ' ')} ({number})"
        return f"{text}: target reached" if self.reached else text


def good_enough(limb_sigma_deg: FloatArray, wanted_deg: float, clicked: int = 0) -> StopSign:
    """Count what misses the wanted accuracy.

    `limb_sigma_deg` (F, 6), NaN where nothing is known, without gaps; so many frames are `clicked`.
    """
    sigma = limb_sigma_deg[:, [LIMBS.index(limb) for limb in SCORED]]
    missing = ~(sigma <= wanted_deg)
    unknown = int((~(sigma <= max(UNKNOWN_DEG, wanted_deg))).any(axis=1).sum())
    by_limb = {limb: int(missing[:, i].sum()) for i, limb in enumerate(SCORED)}
    count = int(missing.any(axis=1).sum())
    return StopSign(
        wanted_deg, len(missing), count, by_limb, frames_unknown=unknown, frames_clicked=clicked
    )


_LARGE_GAP = 10  # frames without a click of a landmark that are worth a word
_APART = 5  # frames around a suggestion in which the same landmark is not suggested again, or later
_SUSPICIOUS = 2.0  # usual sigmas from which a residual makes the sides of a frame be compared
_SKIPPED_DEG = 1.0  # gain of a skipped click that counts at least: it may be nothing
_DISAGREE = 15.0  # degrees between tracker and fit beyond the fit's own uncertainty
_FIT_WRONG = 0.1  # how probably the fit is the one that is wrong, where both disagree
_WORST_DEG = 90.0  # what a limb may be off of which nothing is known


@dataclass(frozen=True)
class Wish:
    """Selection of suggestions: at most so many, in these frames or in all."""

    count: int = 20
    frames: range | None = None
    gaps: Sequence[range] = ()  # flagged stretches, for which nothing is suggested


class NextClicks:
    """The ranking, kept up to date edit by edit; clicks are needed with the deleted ones."""

    def __init__(
        self,
        cameras: Cameras,
        landmark_set: LandmarkSet,
        fit: TrajectoryFit,
        clicks: Iterable[Click],
        *,
        sigma: Sigmas = USUAL_SIGMA,
        run: LandmarkTrajectory | None = None,
    ) -> None:
        known = tuple(clicks)
        self._cameras, self._set = cameras, landmark_set
        usual = list(sigma.values()) if isinstance(sigma, Mapping) else [sigma]
        self._sigma = float(np.median(usual or [USUAL_SIGMA]))
        self.gains = ClickGains(cameras, landmark_set, fit, known, sigma=sigma)
        doubtful = doubtful_camera(known, cameras, landmark_set)
        self._unsound = () if doubtful is None else doubtful.doubtful
        # to click again where a camera is wrong would help nobody
        doubts = doubts_of(fit, cameras, self._sigma)
        kept = own_outliers(doubts, doubtful, known, cameras)
        self._doubts = {key: doubts[key] for key in kept}
        self._doubtful, self._residuals = doubtful, fit.residual_px
        # what is exchanged cannot fit, and comparing the sides in thousands of frames takes long
        limit, residuals = _SUSPICIOUS * self._sigma, fit.residual_px.items()
        suspicious = {key.frame for key, off in residuals if float(np.linalg.norm(off)) > limit}
        self._swaps = swaps_of(known, cameras, landmark_set, suspicious, self._sigma)
        self._apart_deg = None if run is None else disagreement_deg(fit, run)

    def update(self, frame: int, clicks: Iterable[Click]) -> None:
        """Take in the present clicks of an edited frame; see :meth:`ClickGains.update`."""
        there = tuple(clicks)
        self.gains.update(frame, there)
        for known in (self._doubts, self._swaps):
            for key in [key for key in known if key.frame == frame]:
                del known[key]
        self._swaps |= swaps_of(there, self._cameras, self._set, [frame], self._sigma)

    def add(self, doubts: Mapping[ClickKey, Doubt]) -> None:
        """Take in doubts that images tell, unless something else explains them.

        Beside a click that lies far from the fit, or was swapped, every click looks different.
        """
        known = self._doubts | self._swaps
        clicked = self.gains.state == Place.CLICKED
        for key, doubt in doubts.items():
            row = self.gains.row(key.frame)
            if row is None or key.camera not in self.gains.names or key in known:
                continue
            column = self._set.names.index(key.landmark)
            rows = np.flatnonzero(clicked[:, self.gains.names.index(key.camera), column])
            beside = self.gains.frame[[*rows[rows < row][-1:], *rows[rows > row][:1]]]
            if not any(key._replace(frame=frame) in known for frame in beside.tolist()):
                self._doubts[key] = doubt

    def best(self, wish: Wish | None = None) -> tuple[Suggestion, ...]:
        """Doubtful clicks, as nine in ten of these are wrong, then where a new click helps most.

        Each best first; guessed and unsound ones come last.
        Those near a better one of the same kind come after all others, as they may be mended by it.
        """
        wish = Wish() if wish is None else wish
        skipped = self._skipped() & self._wanted(wish)[:, None, None]
        found = [*self._unknown(wish), *self._doubted(wish), *self._new(wish, skipped)]
        found += [*self._disagreeing(wish), *self._left_out(skipped)]
        found.sort(
            key=lambda one: (not one.clear, not one.click_there, -one.over_frames_deg, one.key)
        )
        first = {one.key: one for one in reversed(found)}  # the best one of each click
        return _spread([one for one in found if first[one.key] is one])[: wish.count]

    def _skipped(self) -> BoolArray:
        """Places (F, C, n) that nobody clicked, though they were around and seem to be visible.

        The landmark has a click in that camera in the clicked frames before and after, and in
        another camera in this frame, of which most is clicked: others are not begun in earnest.
        """
        clicked = self.gains.state == Place.CLICKED
        skipped: BoolArray = np.zeros(clicked.shape, dtype=np.bool_)
        for camera in range(clicked.shape[1]):
            rows = np.flatnonzero(clicked[:, camera].any(axis=1))
            own = clicked[rows, camera]
            skipped[rows[1:-1], camera] = own[:-2] & own[2:] & ~own[1:-1]
        visible = self.gains.seen & ~self.gains.hidden & (self.gains.state == Place.FREE)
        mostly = clicked.sum(axis=2) > visible.sum(axis=2)
        return np.asarray(skipped & visible & mostly[..., None] & clicked.any(axis=1)[:, None])

    def _left_out(self, skipped: BoolArray) -> Iterator[Suggestion]:
        for row, camera, landmark in np.argwhere(skipped).tolist():
            gain = max(float(self.gains.gain[row, camera, landmark]), _SKIPPED_DEG)
            place = self.gains.names[camera], self._set.names[landmark]
            words = "clicked in the frames before and after, and seems to be visible here"
            yield Suggestion(
                int(self.gains.frame[row]), *place, gain, words, over_frames_deg=gain,
                clear=place[0] not in self._unsound, kind="skipped",
            )  # fmt: skip

    def _disagreeing(self, wish: Wish) -> Iterator[Suggestion]:
        """The click that is farthest off in each camera that may be wrong."""
        found = self._doubtful
        inside = set(self.gains.frame[self._wanted(wish)].tolist())
        for camera in self._unsound if found is not None else ():
            own = {key: away for key, away in self._residuals.items() if key.camera == camera}
            off = {k: float(np.linalg.norm(own[k])) for k in own if k.frame in inside}
            if off and found is not None:
                key = max(off, key=lambda one: off[one])
                gain = angle_of_residual(found.off_px, self._cameras[camera])
                words, total = what_disagrees(found), gain * len(off)
                yield Suggestion(*key, gain, words, True, total, kind="camera")

    def _new(self, wish: Wish, skipped: BoolArray) -> Iterator[Suggestion]:
        """Places without a click, but for those that were skipped."""
        free = (self.gains.state == Place.FREE) & ~skipped
        gain = np.where(free, self.gains.gain, 0.0)
        if self._apart_deg is not None:  # more where a tracker disagrees
            wrong = _FIT_WRONG * self._excess().sum(axis=1)
            most = np.maximum(gain.max(axis=(1, 2)), 1e-9)
            gain *= (1.0 + wrong / most)[:, None, None]
        total = over_frames(gain, self.gains.clicked(), REACH)
        total[(gain <= 0) | ~self._wanted(wish)[:, None, None]] = 0.0
        clear = ~self.gains.hidden & ~np.isin(self.gains.names, self._unsound)[:, None]
        first = np.where(clear, total.max(initial=0.0), 0.0)
        for _ in range(wish.count):
            best = (total + np.where(total > 0, first, 0.0)).argmax()
            row, camera, landmark = (int(i) for i in np.unravel_index(best, total.shape))
            value = float(total[row, camera, landmark])
            if value <= 0:
                return
            yield Suggestion(
                int(self.gains.frame[row]),
                self.gains.names[camera],
                self._set.names[landmark],
                float(self.gains.gain[row, camera, landmark]),
                self._reason(row, camera, landmark),
                over_frames_deg=value,
                clear=bool(clear[row, camera, landmark]),
            )
            total[max(0, row - _APART) : row + _APART + 1, :, landmark] = 0.0

    def _barred(self, wish: Wish) -> BoolArray:
        return np.isin(self.gains.frame, [frame for gap in wish.gaps for frame in gap])

    def _wanted(self, wish: Wish) -> BoolArray:
        inside = True if wish.frames is None else np.isin(self.gains.frame, wish.frames)
        return ~self._barred(wish) & inside

    def _excess(self) -> FloatArray:
        """Degrees (F, 6) by which tracker and fit disagree more than the fit may be off."""
        if self._apart_deg is None:
            return np.zeros((len(self.gains.frame), len(LIMBS)))
        beyond = self._apart_deg - 3.0 * self.gains.limb_sigma_deg()
        return np.where(beyond > _DISAGREE, beyond, 0.0)

    def _doubted(self, wish: Wish) -> Iterator[Suggestion]:
        wanted = self._wanted(wish)
        for key, doubt in (self._doubts | self._swaps).items():
            row = self.gains.row(key.frame)
            if row is None or not wanted[row]:
                continue
            camera = self.gains.names.index(key.camera)
            landmark = self._set.names.index(key.landmark)
            if self.gains.state[row, camera, landmark] != Place.CLICKED:
                continue
            new_click, p = float(self.gains.gain[row, camera, landmark]), doubt.outlier_probability
            gain = p * new_click + (1.0 - p) * doubt.angle_deg
            clicked = self.gains.clicked()[:, landmark]
            total = gain * float(shares_around(row, clicked, REACH)[1].sum())
            yield Suggestion(*key, gain, doubt.words, True, total, kind=doubt.kind)

    def _unknown(self, wish: Wish) -> Iterator[Suggestion]:
        """Where nothing is known: the middle of every stretch, and open places of begun frames."""
        gain = _WORST_DEG * len(SCORED)
        unknown = ~np.isfinite(self.gains.limb_sigma_deg()).any(axis=1) & ~self._barred(wish)
        clicked = self.gains.clicked()
        for part in stretches_of(unknown & ~clicked.any(axis=1)):
            frame = int(self.gains.frame[(part.start + part.stop - 1) // 2])
            if wish.frames is None or frame in wish.frames:
                reason = f"no information on {counted(len(part), 'frame')}"
                sound = [name for name in self.gains.names if name not in self._unsound]
                place = (frame, (sound or self.gains.names)[0], self._set.names[0])
                total = gain * len(part)
                yield Suggestion(*place, gain, reason, over_frames_deg=total, kind="unknown")
        for row in np.flatnonzero(unknown & clicked.any(axis=1) & self._wanted(wish)):
            free = np.argwhere((self.gains.state[row] == Place.FREE) & ~clicked[row])
            if len(free):
                camera, landmark = free[0]
                frame, name = int(self.gains.frame[row]), self._set.names[landmark]
                place = (frame, self.gains.names[camera], name)
                open_ = counted(len(np.unique(free[:, 1])), "landmark")
                words = f"{open_} open in this frame"
                yield Suggestion(*place, gain, words, over_frames_deg=gain, kind="unknown")

    def _reason(self, row: int, camera: int, landmark: int) -> str:
        """Why a click is asked for: which limb it is for, and what is the matter there."""
        axis = int(np.argmax(self.gains.by_axis(row, camera, landmark)))
        sigma = float(self.gains.sigma_deg[row, axis])
        said = []
        if self.gains.names[camera] in self._unsound:
            said.append("the view disagrees with the others")
        if self.gains.hidden[row, camera, landmark]:
            said.append("occluded, position must be estimated")
        excess = self._excess()[row]
        if excess.max() > 0 and self._apart_deg is not None:
            worst = int(np.argmax(excess))
            name = LIMBS[worst].replace("_", " ")
            apart = self._apart_deg[row, worst]
            said.append(f"tracker and reference differ by {apart:.0f} deg ({name})")
        name, much = AXES[axis].replace("_", " "), spread_words(sigma, " deg")
        clicked = np.flatnonzero(self.gains.clicked()[:, landmark])
        before, after = clicked[clicked < row], clicked[clicked > row]
        end = int(after.min(initial=len(self.gains.frame)))
        gap = 0 if row in clicked else end - int(before.max(initial=-1)) - 1
        unknown = sigma > UNKNOWN_DEG
        said.append(f"{name} unknown" if unknown else f"{name} uncertain ({much})")
        if gap >= (1 if unknown else _LARGE_GAP):
            said.append(f"no click for {gap} frames")
        seen_by = int((self.gains.state[row, :, landmark] == Place.CLICKED).sum())
        if seen_by == 1:
            said.append("clicked in one camera only")
        return ", ".join(said)


def _spread(found: Sequence[Suggestion]) -> tuple[Suggestion, ...]:
    """Suggestions with at least so many frames between those of a kind, then all others."""
    taken: dict[tuple[str, str], list[int]] = {}
    first, later = list[Suggestion](), list[Suggestion]()
    for one in found:
        frames = taken.setdefault((one.kind, "" if one.kind == "swapped" else one.landmark), [])
        near = any(abs(one.frame - frame) <= _APART for frame in frames)
        (later if near else first).append(one)
        if not near:
            frames.append(one.frame)
    return (*first, *later)
