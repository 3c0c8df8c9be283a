"""What the checks say about recordings with a planted fault, and about sound ones."""

from __future__ import annotations

import json
import sys
import time
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

from stereotrack_core.doctor.diagnose import diagnose
from stereotrack_core.errors import Finding
from stereotrack_core.recording.findings import by_severity, examine
from stereotrack_core.recording.folder import open_recording
from tests.doctor.planted.faults import copied, faults, planted
from tests.doctor.planted.sound import Sound, make

_EVERY = 13
"""Rounds after which every fault has been planted into every recording."""


@dataclass(frozen=True)
class Outcome:
    """What was said about one recording; `fault` is empty for a sound one."""

    recording: str
    fault: str
    named: bool
    right: bool
    seconds: float
    findings: tuple[dict[str, str], ...]


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
    begun = time.perf_counter()
    findings = told(folder)
    named, right = fault.named_by(findings)
    return _outcome(sound.name, name, named, right, begun, findings)


def said_of_sound(sound: Path, work: Path) -> Outcome:
    """What is said of a sound recording."""
    folder = work / "sound"
    copied(sound, folder)
    begun = time.perf_counter()
    findings = told(folder)
    alarm = any(one.severity != "note" for one in findings)
    return _outcome(sound.name, "", alarm, False, begun, findings)


def _outcome(
    recording: str, fault: str, named: bool, right: bool, begun: float, found: Sequence[Finding]
) -> Outcome:
    serious = tuple(asdict(one) for one in found if one.severity != "note")
    return Outcome(recording, fault, named, right, time.perf_counter() - begun, serious)


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


def main(root: Path, first: int, end: int, rounds: int = _EVERY) -> None:
    """Plant faults into some recordings, in each round others into each; results as JSON.

    With no rounds only what is said of the sound recordings is kept. What stands in the results is
    not made again, so that this may be stopped.
    """
    results = root / f"outcomes-{first}-{end}.jsonl"
    known = map(json.loads, results.read_text().splitlines() if results.exists() else ())
    done = {(one["recording"], one["fault"]) for one in known}
    work = root / f"work-{first}-{end}"
    with results.open("a") as file:
        for turn, number in product(range(max(rounds, 1)), range(first, end)):
            sound = rendered(root, number)
            other = rendered(root, first + (number + 7 - first) % (end - first))
            names = [
                f.name
                for i, f in enumerate(faults(other))
                if rounds and (i + number - turn) % _EVERY == 0
            ]
            for name in ("", *names):
                if (sound.name, name) in done:
                    continue
                one = (
                    said_of_fault(sound, other, name, work, number)
                    if name
                    else said_of_sound(sound, work)
                )
                done.add((sound.name, name))
                if one is not None:
                    file.write(json.dumps(asdict(one)) + "\n")
                    file.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), *map(int, sys.argv[4:5]))
