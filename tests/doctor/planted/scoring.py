"""What the checks say about recordings with a planted fault, and about sound ones."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.doctor.diagnose import diagnose
from stereotrack_core.errors import Finding
from stereotrack_core.recording.findings import by_severity, examine
from stereotrack_core.recording.folder import open_recording
from tests.doctor.planted.faults import copied, faults, planted
from tests.doctor.planted.sound import Sound, make


@dataclass(frozen=True)
class Outcome:
    """What was said about one recording; `fault` is empty for a sound one."""

    recording: str
    fault: str
    named: bool
    right: bool
    findings: tuple[Finding, ...]


def told(folder: Path) -> tuple[Finding, ...]:
    """Everything that ``info --deep`` says."""
    found = examine(folder, deep=True)
    return by_severity((*found, *diagnose(open_recording(folder))))


def said_of_fault(sound: Path, other: Path, name: str, work: Path, seed: int) -> Outcome | None:
    """What is said of a recording with one fault, None where it cannot be planted there."""
    at, fault = next((i, f) for i, f in enumerate(faults(other)) if f.name == name)
    folder = work / "planted"
    if not planted(fault, sound, folder, (seed, at)):
        return None
    findings = told(folder)
    return Outcome(sound.name, name, *fault.named_by(findings), findings)


def said_of_sound(sound: Path, work: Path) -> Outcome:
    """What is said of a sound recording."""
    folder = work / "sound"
    copied(sound, folder)
    findings = tuple(one for one in told(folder) if one.severity != "note")
    return Outcome(sound.name, "", bool(findings), False, findings)


def table(outcomes: Iterable[Outcome]) -> str:
    """Counts by kind of fault, and of false alarms, as lines of text."""
    by_fault: dict[str, list[Outcome]] = defaultdict(list)
    for one in outcomes:
        by_fault[one.fault].append(one)
    lines = []
    for name, some in by_fault.items():
        named, right = sum(o.named for o in some), sum(o.right for o in some)
        said = f"named {named}/{len(some)}, right cause {right}/{len(some)}"
        lines.append(f"{name}: {said}" if name else f"sound: {named} false alarms of {len(some)}")
    every = [one for name, some in by_fault.items() for one in some if name]
    named, right = sum(o.named for o in every), sum(o.right for o in every)
    lines.append(f"all faults: named {named}, right cause {right} of {len(every)}")
    return "\n".join(lines)


def rendered(root: Path, number: int) -> Path:
    """The folder of a sound recording, rendered where it is not there yet."""
    sound = Sound(number)
    if not (root / sound.name / "recording.toml").is_file():
        make(sound, root / sound.name)
    return root / sound.name
