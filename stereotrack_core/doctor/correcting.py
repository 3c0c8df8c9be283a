"""Correct what a check has found in the recording's files, if the same checks agree.

The new file takes its place, and the old one is kept beside it, only if the problem is gone.
Corrected are exchanged images, units, transposed rotations and delays.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from stereotrack_core.atomic import forget_unfinished, replacing, write_file
from stereotrack_core.doctor.diagnose import diagnose
from stereotrack_core.errors import Correction, CorrectionKind, Finding, InputError
from stereotrack_core.recording.calibration import edited_calibration
from stereotrack_core.recording.camera_checks import transposed
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.findings import ORDER, by_severity, examine, examine_described
from stereotrack_core.recording.folder import DESCRIPTION, describe, named_file, open_recording
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.recording.writing import keep_beside
from stereotrack_core.worker_processes import Asker

_NUMBER = re.compile(r"-?\d[\d.,]*")
_STREAMS = ("left", "right", "image", "depth", "mask")
_WORDS: dict[CorrectionKind, str] = {
    "transpose": "Transpose the rotation of {names}.",
    "scale_translation": "Multiply the translation of {names} by {amount:.4g}.",
    "exchange_pair": "Exchange the files of left and right in view {names}.",
    "exchange_views": "Exchange the files of the views {names}.",
    "shift_frames": "Change first_frame of the streams of view {names} by {amount:+.0f} (or that "
    "of all others, if there are not so many frames before it).",
    "shift_left": "Change first_frame of the left image of view {names} by {amount:+.0f} (or that "
    "of all others, if there are not so many frames before it).",
}


@dataclass(frozen=True)
class Corrected:
    """A file that was corrected, the copy of it from before, and the findings since then."""

    file: Path
    kept: Path
    words: str
    measured: tuple[Finding, ...]


def words_of(correction: Correction) -> str:
    """Sentence that states what a correction changes."""
    names = " and ".join(filter(None, (", ".join(correction.names[:-1]), correction.names[-1])))
    return _WORDS[correction.kind].format(names=names, amount=correction.amount)


def intended(folder: Path, correction: Correction) -> str:
    """Sentence that states what a correction would change, and in which file."""
    return f"{_file_of(folder, correction).name}: {words_of(correction)}"


def correct(
    folder: Path, finding: Finding, tell: Callable[[str], None] = lambda _words: None
) -> Corrected:
    """Make the correction of a finding, if the finding is gone then. Raises InputError else.

    Reads as much as :func:`diagnose`; `tell` is told what is looked at.
    """
    correction = finding.correction
    if correction is None:
        raise InputError("it has no correction", finding.where, finding.remedy)
    recording, path = open_recording(folder), _file_of(folder, correction)
    forget_unfinished(path)
    text = corrected_text(recording, path, correction).encode()
    with replacing(path, lambda written: written.read_bytes() == text) as temporary:
        write_file(temporary, text)
        content = load_toml(temporary)
        if _of_cameras(correction):
            named = {"calibration": temporary.relative_to(folder).as_posix()}
            content = load_toml(folder / DESCRIPTION) | named
        complaints: list[InputError] = []
        changed = describe(folder, complaints, content)
        if complaints or changed is None:
            raise complaints[0]
        files, measured = examine_described(changed), diagnose(changed, tell)
        reason = _why_not(finding, examine_described(recording), files, measured)
        if reason:
            raise InputError(
                f"{path.name} stays as it was: with this correction "
                f"({words_of(correction).rstrip('.')}) {reason}",
                finding.where,
                finding.remedy,
            )
        kept = keep_beside(path)
    return Corrected(path, kept, words_of(correction), measured)


def correct_all(
    folder: Path, found: Sequence[Finding], say: Callable[[str], None]
) -> Iterator[Corrected]:
    """Make corrections one after the other, also of new findings; `say` is told of each."""
    tried: set[tuple[str, Correction]] = set()
    waiting = list(found)
    while waiting:
        finding = waiting.pop(0)
        correction = finding.correction
        if correction is None or finding.severity == "note" or (finding.where, correction) in tried:
            continue
        tried.add((finding.where, correction))
        try:
            say(f"{finding.where}: {finding.what}.")
            say(f"Testing a correction of {intended(folder, correction)}")
            done = correct(folder, finding)
        except InputError as error:
            say(f"Not corrected: {error}")
            continue
        say(f"Corrected. The file before is {done.kept.name}.")
        yield done
        waiting = list(by_severity((*examine(folder, compare=True), *done.measured)))


def correct_elsewhere(folder: Path, finding: Finding, asker: Asker) -> Corrected:
    """The same in a process that works for a window."""
    return correct(folder, finding, asker.tell)


def _of_cameras(correction: Correction) -> bool:
    return correction.kind in ("transpose", "scale_translation")


def _file_of(folder: Path, correction: Correction) -> Path:
    if _of_cameras(correction):
        return named_file(folder, "calibration")
    return folder / DESCRIPTION


def _why_not(
    finding: Finding,
    before: Sequence[Finding],
    files: Sequence[Finding],
    measured: Sequence[Finding],
) -> str:
    """Why a corrected recording is not better, by findings before and after; empty if it is."""
    stem = _stem(finding)
    for one in (*files, *measured):
        grave = ORDER[one.severity] <= ORDER[finding.severity] or _stem(one) == stem
        if one.where == finding.where and one.severity != "note" and grave:
            return "the problem would not be gone"
    known = {(one.where, _stem(one)) for one in before}
    for one in files:
        if one.severity == "error" and (one.where, _stem(one)) not in known:
            return f"there would be another one ({one.where}: {one.what})"
    return ""


def _stem(finding: Finding) -> str:
    """Text of a finding without its numbers."""
    return _NUMBER.sub("#", finding.what)


def corrected_text(recording: Recording, path: Path, correction: Correction) -> str:
    """The text of the file at `path` with a correction. Raises InputError."""
    if _of_cameras(correction):
        cameras = [recording.cameras[name] for name in correction.names]
        turn = correction.kind == "transpose"
        mended = {c.name: transposed(c) if turn else c.scaled(correction.amount) for c in cameras}
        return edited_calibration(path, mended)
    content = load_toml(path)
    if correction.kind in ("shift_frames", "shift_left"):
        _shift(content, recording, correction)
    else:
        views = {view["name"]: view for view in content["views"]}
        _exchange([views[name] for name in correction.names])
    return tomli_w.dumps(content)


def _exchange(views: Sequence[dict[str, Any]]) -> None:
    """Exchange the files of the two streams of a pair, or those of two views, but no cameras."""
    if len(views) == 1:
        pairs = [(views[0]["left"], views[0]["right"])]
    else:
        one, other = views
        if [key in one for key in _STREAMS] != [key in other for key in _STREAMS]:
            what = f"the views {one['name']} and {other['name']} have other streams"
            raise InputError(what, DESCRIPTION, "Exchange the files by hand.")
        pairs = [(one[key], other[key]) for key in _STREAMS if key in one]
    for a, b in pairs:
        files = [{key: one[key] for key in one if key != "camera"} for one in (b, a)]
        for stream, taken in zip((a, b), files, strict=True):
            camera = {"camera": stream["camera"]} if "camera" in stream else {}
            stream.clear()
            stream.update(camera | taken)


def _shift(content: dict[str, Any], recording: Recording, correction: Correction) -> None:
    """Let streams of a view begin later by some frames, or all others earlier."""
    count = round(correction.amount)
    keys = ("left",) if correction.kind == "shift_left" else _STREAMS
    there = [(view, key) for view in content["views"] for key in _STREAMS if key in view]
    streams = [(v[key], v["name"] in correction.names and key in keys) for v, key in there]
    begins = [int(stream.get("first_frame", 0)) + count * late for stream, late in streams]
    lacking = max(0, -min(begins))
    if lacking and (recording.reference is not None or recording.segments):
        raise InputError(
            "the other streams would have to begin later, and reference and segments count "
            "frames from their beginning",
            DESCRIPTION,
            "Change first_frame, and the frames of reference and segments.",
        )
    for (stream, _), begin in zip(streams, begins, strict=True):
        if begin + lacking or "first_frame" in stream:
            stream["first_frame"] = begin + lacking
