"""Fit the body to clicks: ``python fit_clicks.py RECORDING CLICKS.csv REFERENCE.csv``."""

import sys
from pathlib import Path

import numpy as np

import stereotrack_core as stereotrack
from stereotrack_core.recording.landmarks import write_landmarks


def main(folder: Path, clicks: Path, output: Path) -> None:
    recording = stereotrack.open_recording(folder)
    fit = stereotrack.fit_reference(recording, stereotrack.read_clicks(clicks, recording).checked())
    write_landmarks(output, fit.trajectory())
    print(f"{len(fit.frame)} frames, of which {(fit.kind == 'clicked').sum()} are clicked")
    for key in fit.flagged():
        off = np.linalg.norm(fit.residual_px[key])
        print(f"{key.landmark} in {key.camera}, frame {key.frame}: {off:.0f} px off")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
