"""Correct what a check has found, where the same checks say that it is right then.

The new file is written beside the old one and checked as if it stood there. It takes its place, and
the old one is kept beside it, only if the problem is gone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.atomic import forget_unfinished, replacing, write_file
from stereotrack_core.doctor.corrections import corrected_text, file_of, key_of, words_of
from stereotrack_core.doctor.diagnose import diagnose
from stereotrack_core.errors import Correction, Finding, InputError
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.findings import ORDER, by_severity, examine, examine_described
from stereotrack_core.recording.folder import DESCRIPTION, describe, open_recording
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.recording.writing import keep_beside
from stereotrack_core.worker_processes import Asker

_NUMBER = re.compile(r"-?\d[\d.,]*")


@dataclass(frozen=True)
class Corrected:
    """A file that was corrected.

    `kept` is the one before, `words` say what was changed, and `measured` is what
    :func:`diagnose` says now.
    """

    file: Path
    kept: Path
    words: str
    measured: tuple[Finding, ...]


def intended(folder: Path, correction: Correction) -> str:
    """What a correction would change in which file, as a sentence.

    Raises InputError where the recording has no such file.
    """
    return f"{file_of(folder, correction).name}: {words_of(correction)}"


def correct(
    folder: Path, finding: Finding, tell: Callable[[str], None] = lambda _words: None
) -> Corrected:
    """Make the correction of a finding, where the finding is gone then.

    Reads as much as :func:`diagnose`; `tell` is told what is looked at. Raises InputError where
    the problem remains, or a file cannot be read or written; then nothing is changed.
    """
    correction = finding.correction
    if correction is None:
        raise InputError(
            "no correction of this is known", where=finding.where, remedy=finding.remedy
        )
    recording, path = open_recording(folder), file_of(folder, correction)
    forget_unfinished(path)
    before = read_bytes(path, TABLE_BYTES)
    text = corrected_text(recording, path, correction).encode()
    with replacing(path, lambda written: written.read_bytes() == text) as temporary:
        write_file(temporary, text)
        changed = _described(folder, key_of(correction), temporary)
        files, measured = examine_described(changed), diagnose(changed, tell)
        reason = _why_not(finding, recording, files, measured)
        if reason:
            raise InputError(
                f"{path.name} stays as it was: with this correction "
                f"({words_of(correction).rstrip('.')}) {reason}",
                where=finding.where,
                remedy=finding.remedy,
            )
        if read_bytes(path, TABLE_BYTES) != before:
            raise InputError(
                "it was changed while the correction was tested, and stays as it is now",
                where=str(path),
                remedy="Check the recording again.",
            )
        kept = keep_beside(path)
    return Corrected(path, kept, words_of(correction), measured)


def correct_all(
    folder: Path, found: Sequence[Finding], say: Callable[[str], None]
) -> Iterator[Corrected]:
    """Make the corrections of findings one after the other, also of what is found only then.

    `say` is told what is tried and what came of it.
    """
    tried: set[tuple[str, Correction]] = set()
    while True:
        finding = next((one for one in found if _is_new(one, tried)), None)
        if finding is None or finding.correction is None:
            return
        tried.add((finding.where, finding.correction))
        try:
            say(f"{finding.where}: {finding.what}.")
            say(f"Testing a correction of {intended(folder, finding.correction)}")
            done = correct(folder, finding)
        except InputError as error:
            say(f"Not corrected: {error}")
            continue
        say(f"Corrected. The file before is {done.kept.name}.")
        yield done
        found = by_severity((*examine(folder, compare=True), *done.measured))


def _is_new(finding: Finding, tried: set[tuple[str, Correction]]) -> bool:
    correction = finding.correction
    if correction is None or finding.severity == "note":
        return False
    return (finding.where, correction) not in tried


def correct_elsewhere(folder: Path, finding: Finding, asker: Asker) -> Corrected:
    """The same in a process that works for a window."""
    return correct(folder, finding, asker.tell)


def _described(folder: Path, key: str, temporary: Path) -> Recording:
    """The recording with a file in place of the one that its description names by a key."""
    content = load_toml(folder / DESCRIPTION if key else temporary)
    complaints: list[InputError] = []
    named = {key: temporary.relative_to(folder).as_posix()} if key else {}
    changed = describe(folder, complaints, content | named)
    if complaints or changed is None:
        raise complaints[0]
    return changed


def _why_not(
    finding: Finding,
    recording: Recording,
    files: Sequence[Finding],
    measured: Sequence[Finding],
) -> str:
    """Why a correction is none, by what is found after it; empty where it is one."""
    if remains(finding, (*files, *measured)):
        return "the problem would not be gone"
    known = {(one.where, _stem(one.what)) for one in examine_described(recording)}
    for one in files:
        grave = one.severity == "error" or (one.where == finding.where and one.severity != "note")
        if grave and (one.where, _stem(one.what)) not in known:
            return f"there would be another one ({one.where}: {one.what})"
    return ""


def remains(finding: Finding, after: Sequence[Finding]) -> bool:
    """Whether a problem is still found, or another one at its place that is no lighter.

    At most one check looks at a place in the files of cameras and of the description; of a view or
    a reference, another problem may be seen only when the first is gone.
    """
    kind = finding.correction and finding.correction.kind
    alone = finding.where.startswith(("calibration.toml", "recording.toml"))
    alone |= kind == "exchange_pair"  # pictures that are mirrored may look exchanged to one view
    return any(
        _stem(one.what) == _stem(finding.what)
        or (one.correction is not None and one.correction.kind == kind)
        or ORDER[one.severity] < ORDER[finding.severity] + alone
        for one in after
        if one.where == finding.where and one.severity != "note"
    )


def _stem(words: str) -> str:
    """Words without their numbers."""
    return _NUMBER.sub("#", words)
