"""When sources show the same instant: by their start times, or a flash, clap or motion they share.

Each method turns a source into a signal over time, one number per frame or millisecond. Two signals
are laid over each other where their normalised correlation is highest, between samples by a
parabola. The answer is refused where they agree too little, or as well elsewhere.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import av
import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import reason
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.importing.choices import Choices, Source
from stereotrack_core.recording.importing.readers import open_source
from stereotrack_core.recording.importing.video_sources import MOST_UNEVEN
from stereotrack_core.recording.video import open_container, video_stream
from stereotrack_core.tables import finite_number, read_rows, whole_number
from stereotrack_core.work import NO_WORK, Work

SOUND_RATE = 1000.0  # values per second of :func:`loudness`
_WIDTH, _HEIGHT = 80, 60  # pixels to which images are reduced
_SAMPLES = 16_000  # per second, of the sound
_PER_VALUE = int(_SAMPLES / SOUND_RATE)
_SLOW = 15.0  # frames
_STILL = 2.0  # levels of 255; smaller changes of a pixel are noise


@dataclass(frozen=True, eq=False)
class Signal:
    """Values at equal steps of time."""

    values: FloatArray  # (N,)
    begin: float = 0.0  # seconds of the first value after the first frame of the source


def brightness(source: Source, work: Work) -> Signal:
    """Rise of the mean brightness from the frame before (F,); 0 where it falls."""
    means = np.array([float(picture.mean()) for picture in _pictures(source, work)])
    return Signal(np.concatenate([[0.0], np.maximum(np.diff(means), 0.0)]))


def motion(source: Source, work: Work) -> Signal:
    """How much faster pixels change than in the frames around; see :func:`motion_of`."""
    return Signal(motion_of(_pictures(source, work)))


def motion_of(pictures: Iterable[FloatArray]) -> FloatArray:
    """How much faster pixels change than in the frames around (F,), of :func:`reduced` pictures.

    The square root of their mean change from the frame before, without what varies slowly: phases
    of rest and motion look alike to each other wherever they are laid.
    """
    from scipy.ndimage import gaussian_filter1d

    values, before = [0.0], None
    for picture in pictures:
        if before is not None:
            change = np.abs(picture - before)
            values.append(float(np.sqrt(np.maximum(change - _STILL, 0.0).mean())))
        before = picture
    values[0] = values[1] if len(values) > 1 else 0.0
    slow = gaussian_filter1d(values, _SLOW)
    return np.asarray(np.array(values) - slow)


def loudness(source: Source, work: Work) -> Signal:
    """Rise of the sound's loudness (N,), one value a millisecond; InputError without sound."""
    if not source.sound:
        what = f"{source.name} has no sound"
        raise InputError(what, source.path, "Use another method, such as motion.")
    try:
        with open_container(source.path) as container:
            stream = video_stream(container)
            shown = float((stream.start_time or 0) * stream.time_base)
        samples, heard = _sound(source, work)
    except (av.FFmpegError, OSError, IndexError) as error:
        what = f"its sound cannot be read ({reason(error)})"
        raise InputError(what, source.path, "Use another method, such as motion.") from None
    count = len(samples) // _PER_VALUE
    loud = np.abs(samples[: count * _PER_VALUE]).reshape(count, _PER_VALUE).mean(axis=1)
    rise = np.maximum(np.diff(loud, prepend=loud[:1]), 0.0)
    return Signal(rise, heard - shown)


def _sound(source: Source, work: Work) -> tuple[FloatArray, float]:
    """Samples of one channel, and the time of the first in seconds."""
    resampler = av.AudioResampler("flt", "mono", _SAMPLES)
    parts: list[Any] = []
    begin: float | None = None
    with open_container(source.path) as container:
        for frame in container.decode(audio=0):
            work.check()
            if begin is None:
                begin = float((frame.pts or 0) * frame.time_base)
            parts += [one.to_ndarray().ravel() for one in resampler.resample(frame)]
    parts += [one.to_ndarray().ravel() for one in resampler.resample(None)]
    return np.concatenate(parts).astype(np.float64), begin or 0.0


def _pictures(source: Source, work: Work) -> Iterator[FloatArray]:
    """All pictures in grey, reduced (H, W) float32; a damaged one counts as the one before."""
    depth = source.kind == "depth"
    before: Any = np.zeros((_HEIGHT, _WIDTH), np.float32)
    with closing(open_source(source, "depth" if depth else "grey")) as reader:
        for k in range(reader.count()):
            work.check()
            with suppress(DamagedFrame):
                picture: Any = reader.read(k, lambda _number, _picture: None)
                before = reduced(picture.astype(np.float32) / (64.0 if depth else 1.0))
            yield before


def reduced(picture: Any) -> FloatArray:
    """A grey picture reduced to (H, W) float32, as :func:`motion_of` compares them."""
    small = picture.astype(np.float32, copy=False)
    return np.asarray(cv2.resize(small, (_WIDTH, _HEIGHT), interpolation=cv2.INTER_AREA))


Method: TypeAlias = Literal["start", "flash", "clap", "motion"]

METHODS: Mapping[Method, str] = {
    "start": "start times of the files",
    "flash": "a flash of light that all cameras see",
    "clap": "a clap or other sound that all cameras record",
    "motion": "the motion that all cameras see",
}
"""Every method in words."""

TIMESTAMPS = "timestamps.csv"
_LEAST_CORRELATION = 0.45
_LEAST_SCORE = 3.2
"""Standard deviations from chance, of which unrelated motion reaches so many in 1 of 25 tries."""
_MOST_MEMORY = 40  # frames or milliseconds over which a signal is like itself
_MOST_ELSEWHERE = 0.75
"""Correlation of the second best place over that of the best, from which neither is certain."""
_LEAST_OVERLAP = 0.5  # of the energy of each signal
_USUAL_PERCENT = 95.0
_LEAST_EVENT = 4.0  # times what all but a few rises are below; then it is an event


@dataclass(frozen=True)
class Lead:
    """The place in a source of what the first source shows in its frame 0."""

    source: str
    frames: float  # the source's own frame there; with fractions, negative where it starts later
    correlation: float  # how well the signals agree, at most 1
    elsewhere: float  # how well they agree in the second best place

    def says(self, fps: float) -> str:
        """Place and evidence in words."""
        agreement = f", correlation {self.correlation:.2f}" if self.elsewhere else ""
        late = f"{1000 * self.frames / fps:+z.0f} ms{agreement}"
        return f"{self.source}: {self.frames:+z.2f} frames ({late})"


def synchronised(
    choices: Choices, method: Method, work: Work = NO_WORK
) -> tuple[Choices, tuple[Lead, ...]]:
    """Choices whose sources begin at the same instant, and the evidence; see :func:`leads_of`.

    A depth map and a mask are taken to be of the same instants as the image of their view.
    """
    if choices.fps is None:
        what = "the files do not state their frame rate"
        raise InputError(what, remedy="Give the frames per second.")
    used = choices.used()
    pictured = {use.view for use in used if use.role == "image"}
    follow = [u for u in used if u.role == "mask" or (u.role == "depth" and u.view in pictured)]
    asked = [use for use in used if use not in follow]
    sources = [use.source for use in asked]
    leads = leads_of(sources, method, choices.fps, work)
    found = {lead.source: lead.frames for lead in leads}
    of_view = {use.view: found[use.source.name] for use in asked}
    uses = tuple(
        use
        if use.role == "unused"
        else replace(use, lead=found.get(use.source.name, of_view[use.view]))
        for use in choices.uses
    )
    return replace(choices, uses=uses), leads


def leads_of(
    sources: Sequence[Source], method: Method, fps: float, work: Work = NO_WORK
) -> tuple[Lead, ...]:
    """Where each source shows what the first shows in its frame 0; all have the same rate.
    InputError where one lacks what the method needs, or evidence is weak; Cancelled on request.
    """
    if method == "start":
        starts = [_start_of(source) for source in sources]
        pairs = zip(sources, starts, strict=True)
        return tuple(Lead(one.name, (starts[0] - own) * fps, 1.0, 0.0) for one, own in pairs)
    read = {"flash": brightness, "clap": loudness, "motion": motion}[method]
    signals = []
    for k, source in enumerate(sources):
        work.step(k / len(sources), f"reading {source.name}")
        signals.append(read(source, work))
        if method != "motion":
            _check_event(signals[-1].values, source, method)
    first = signals[0]
    leads = [Lead(sources[0].name, 0.0, 1.0, 0.0)]
    rate = SOUND_RATE if method == "clap" else fps
    for source, signal in zip(sources[1:], signals[1:], strict=True):
        lag, best, second = best_lag(first.values, signal.values)
        score = score_of(first.values, signal.values, round(lag), best)
        _check_evidence(source, sources[0], (best, second, score))
        if method == "flash":
            peak = int(np.argmax(first.values))  # its rise, which exposures share between frames
            lag = _centre(signal.values, peak + round(lag)) - _centre(first.values, peak)
        seconds = lag / rate + signal.begin - first.begin
        leads.append(Lead(source.name, seconds * fps, best, second))
    return tuple(leads)


def best_lag(one: FloatArray, other: FloatArray) -> tuple[float, float, float]:
    """Lag in samples at which two signals (N,), (M,) agree best: ``other[k + lag]`` is ``one[k]``.

    Also the correlation there, and that of the second best place; lags lie between samples.
    """
    a, b = one - one.mean(), other - other.mean()
    size = 1 << int(np.ceil(np.log2(len(a) + len(b))))
    products = np.fft.irfft(np.conj(np.fft.rfft(a, size)) * np.fft.rfft(b, size), size)
    lags = np.arange(-(len(a) - 1), len(b))
    overlap_a = _energies(a, -lags, len(b))
    overlap_b = _energies(b, lags, len(a))
    floor_a, floor_b = _LEAST_OVERLAP * (a @ a), _LEAST_OVERLAP * (b @ b)
    scale = np.sqrt(np.maximum(overlap_a, floor_a) * np.maximum(overlap_b, floor_b))
    correlation = products[lags % size] / np.maximum(scale, 1e-12)
    peak = int(np.argmax(correlation))
    first = last = peak
    while first > 0 and correlation[first - 1] < correlation[first]:
        first -= 1
    while last < len(lags) - 1 and correlation[last + 1] < correlation[last]:
        last += 1
    rest = np.concatenate([correlation[:first], correlation[last + 1 :]])
    second = float(rest.max()) if rest.size else 0.0
    return float(lags[peak] + beside_least(-correlation, peak)), float(correlation[peak]), second


def beside_least(values: FloatArray, at: int) -> float:
    """Shift from a least value (N,) to the bottom of the parabola through it and its neighbours."""
    if not 0 < at < len(values) - 1:
        return 0.0
    before, least, after = values[at - 1 : at + 2]
    bend = before - 2 * least + after
    return float(0.5 * (before - after) / bend) if bend > 0 else 0.0


def _centre(values: FloatArray, peak: int) -> float:
    """Centre of what rises within a frame of `peak`."""
    near = np.arange(max(peak - 1, 0), min(peak + 2, len(values)))
    total = float(values[near].sum())
    return float((near * values[near]).sum() / total) if total > 0 else float(peak)


def _energies(signal: FloatArray, starts: np.ndarray, length: int) -> FloatArray:
    """Sum of squares of the part of a signal that begins at each start and has that length."""
    sums = np.concatenate([[0.0], np.cumsum(signal**2)])
    begin = np.clip(starts, 0, len(signal))
    end = np.clip(starts + length, 0, len(signal))
    return np.asarray(sums[end] - sums[begin])


def _check_event(values: FloatArray, source: Source, method: Method) -> None:
    """Refuse a signal that no event stands out of."""
    what = "flash of light" if method == "flash" else "sudden sound"
    peak = int(np.argmax(values))
    rest = np.delete(values, np.arange(max(peak - 2, 0), min(peak + 3, len(values))))
    usual = float(np.percentile(rest, _USUAL_PERCENT)) if rest.size else 0.0
    if values.max() <= 0 or values.max() < _LEAST_EVENT * usual:
        what = f"no {what} stands out in {source.name}"
        remedy = "Use another method, or give the first frames by hand."
        raise InputError(what, source.path, remedy)


def score_of(one: FloatArray, other: FloatArray, lag: int, correlation: float) -> float:
    """Standard deviations by which signals agree better than by chance (Fisher's z).

    Values beside each other are alike where motion is smooth, so that they count for less
    (Bartlett's formula).
    """
    shared = min(len(one), len(other) - lag) - max(0, -lag)
    alike = _autocorrelation(one) * _autocorrelation(other)
    count = max(shared, 1) / max(1.0 + 2.0 * float(alike.sum()), 1.0)
    return float(np.arctanh(min(correlation, 0.999)) * np.sqrt(max(count - 3.0, 0.0)))


def _autocorrelation(signal: FloatArray) -> FloatArray:
    """Correlation of a signal with itself, 1 to ``_MOST_MEMORY`` values later."""
    centred = signal - signal.mean()
    energy = max(float(centred @ centred), 1e-12)
    steps = range(1, _MOST_MEMORY + 1)
    return np.array([float(centred[:-k] @ centred[k:]) / energy for k in steps])


def _check_evidence(source: Source, first: Source, evidence: tuple[float, float, float]) -> None:
    """Refuse two signals that hardly agree, that agree in several places, or by chance.

    `evidence` is the best correlation, that in the second best place, and the score of the best.
    """
    best, second, score = evidence
    if best < _LEAST_CORRELATION:
        why = f"they hardly agree (correlation {best:.2f})"
    elif second > _MOST_ELSEWHERE * best:
        why = f"they agree in two places almost equally ({best:.2f} and {second:.2f})"
    elif score < _LEAST_SCORE:
        why = f"so little happens in them that they may agree by chance (correlation {best:.2f})"
    else:
        return
    what = f"{source.name} and {first.name} cannot be synchronised: {why}"
    remedy = "Use longer files, another method, or give the first frames by hand."
    raise InputError(what, source.path, remedy)


def _start_of(source: Source) -> float:
    """Seconds of the first frame that is used, by a timestamps.csv beside it, else by metadata."""
    for folder in (source.path.parent, source.path.parent.parent):
        path = folder / TIMESTAMPS
        rows = read_rows(path, ("frame", "view", "seconds")) if path.is_file() else ()
        for line, cells in rows:
            own = cells["view"] == source.name
            if own and whole_number(cells["frame"], path, line, "frame") == 0:
                return finite_number(cells["seconds"], path, line, "seconds") + source.begin
    if source.start is None:
        what = "the file does not state its start time with fractions of a second"
        remedy = f"Use another method, or add a {TIMESTAMPS} with frame, view and seconds."
        raise InputError(what, source.path, remedy)
    return source.start + source.begin


_MOST_DRIFT = 0.5  # frames over the length of a source
_SAME_START = 0.25  # frames
_SAME_LENGTH = 0.1  # of the length, within which cameras that were started together stop


def at_one_rate(choices: Choices) -> Choices:
    """Choices whose sources all have the frame rate of the recording, and begin together by stamps.

    Sources whose rate is uneven or differs are resampled; where all state the instant of each
    frame, from the first instant that all of them show. A rate that is given for files that all
    state another one is taken as the right one. Sources that state none are taken frame by frame.
    Raises InputError where stamped sources have no time in common, or one without rate has another
    length.
    """
    used = choices.used()
    sources = [use.source for use in used]
    stated = [one for one in sources if one.fps is not None]
    if choices.fps is None or not stated:
        return choices
    rates = [one.fps for one in stated if one.fps is not None]
    agree = all(_drift(one, rates[0]) <= _MOST_DRIFT for one in stated)
    corrected = agree and all(_drift(s, choices.fps) > _MOST_DRIFT for s in stated)
    rate = rates[0] if corrected else choices.fps
    if choices.resample:
        _check_length(sources, stated, choices.fps)
    begin = _common_begin(sources, rate)
    uses = []
    for use in choices.uses:
        source = replace(use.source, rate=None, begin=0.0)
        if choices.resample and use in used:
            source = _resampled(source, rate, begin)
        uses.append(replace(use, source=source))
    return replace(choices, uses=tuple(uses))


def _check_length(sources: list[Source], stated: list[Source], rate: float) -> None:
    """Refuse to guess the rate of a source whose frames do not fill the time of the others."""
    lengths = [one.frames / one.fps for one in stated if one.fps is not None]
    for one in sources:
        seconds = one.frames / rate
        if one.fps is None and not any(abs(seconds / s - 1) < _SAME_LENGTH for s in lengths if s):
            raise InputError(
                f"{one.name} does not state its frame rate: at {rate:.5g} frames per second, its "
                f"{one.frames} frames last {seconds:.1f} s, {stated[0].name} {lengths[0]:.1f} s",
                one.path,
                f"Give its frames per second, on the command line with --fps {one.name}=N.",
            )


def _resampled(source: Source, rate: float, begin: float | None) -> Source:
    if begin is not None:
        return replace(source, rate=rate, begin=begin - source.times[0])
    if source.fps is None:
        return source
    needed = source.uneven > MOST_UNEVEN or _drift(source, rate) > _MOST_DRIFT
    return replace(source, rate=rate) if needed else source


def _drift(source: Source, rate: float) -> float:
    """Frames that a source is off at its end when it is shown at a rate."""
    return 0.0 if source.fps is None else source.frames * abs(source.fps / rate - 1.0)


def _common_begin(sources: list[Source], rate: float) -> float | None:
    """The instant at which stamped sources begin; None where they need not be resampled."""
    if not all(one.times for one in sources):
        return None
    begins = [one.times[0] for one in sources]
    even = all(one.uneven <= MOST_UNEVEN and _drift(one, rate) <= _MOST_DRIFT for one in sources)
    if even and (max(begins) - min(begins)) * rate <= _SAME_START:
        return None
    last = min(sources, key=lambda one: one.times[-1])
    latest = max(sources, key=lambda one: one.times[0])
    if last.times[-1] <= latest.times[0]:
        apart = latest.times[0] - last.times[-1]
        what = f"{last.name} ends {apart:.1f} s before {latest.name} begins"
        raise InputError(what, last.path, "Use sources of the same time, or whose clocks agree.")
    return latest.times[0]
