"""What a parameter changes: ``python compare_settings.py RECORDING iterations=2 iterations=6``."""

import sys
from collections.abc import Sequence
from pathlib import Path

import stereotrack_core as stereotrack


def main(folder: Path, changes: Sequence[str], preset: str = "accurate") -> None:
    recording = stereotrack.open_recording(folder)
    for change in changes:
        settings = stereotrack.preset(preset, change.split())
        run = stereotrack.track(recording, stereotrack.RunSpec(settings))
        unexplained = float(run.unexplained_fraction[run.tracked].mean())
        print(
            f"{change}: {run.tracked.sum()} frames tracked, {unexplained:.3f} unexplained", end=""
        )
        if recording.reference is not None:
            summary = stereotrack.evaluate(run, recording.reference)
            forearms = summary.measure("forearms").statistics.mean
            print(f", forearms {forearms:.1f} deg off", end="")
        print()


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
