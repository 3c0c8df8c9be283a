"""Track a recording and measure the errors: ``python track_and_evaluate.py RECORDING RUN.npz``."""

import sys
from pathlib import Path

import stereotrack_core as stereotrack


def main(folder: Path, output: Path, preset: str = "accurate") -> None:
    recording = stereotrack.open_recording(folder)
    spec = stereotrack.RunSpec(stereotrack.preset(preset), preset=preset)
    run = stereotrack.track(recording, spec)
    stereotrack.write_run(output, run)

    if recording.reference is not None:
        summary = stereotrack.evaluate(run, recording.reference)
        for measure in summary.measures:
            print(f"{measure.label}: {measure.statistics.mean:.1f} {measure.unit}")
    for failure in stereotrack.failures(run, reference=recording.reference):
        print(f"{', '.join(failure.limbs)} fail from frame {failure.first} to {failure.last}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:])
