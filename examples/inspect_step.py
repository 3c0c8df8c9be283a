"""What one step of the tracker did: ``python inspect_step.py RECORDING FRAME``."""

import sys
from pathlib import Path

import stereotrack_core as stereotrack
from stereotrack_core.tracking.inspection import look_inside
from stereotrack_core.tracking.pipeline import Pipeline


def main(folder: Path, frame: int, preset: str = "accurate") -> None:
    recording = stereotrack.open_recording(folder)
    spec = stereotrack.RunSpec(stereotrack.preset(preset))
    with Pipeline(recording, spec) as pipeline:
        before = list(pipeline.frames(range(frame)))
        cloud = pipeline.chain.process(pipeline.reader.frame_set(frame))
        trace = look_inside(pipeline.tracker, cloud)  # the tracker stays as it is

    print(f"{len(before)} frames were tracked before; frame {trace.frame} by {trace.method}")
    for correction in trace.corrections:
        residual_mm = 1000.0 * abs(correction.points.residual).mean()
        print(
            f"  {correction.stage} {correction.iteration}: {len(correction.P_zz)} points, "
            f"{residual_mm:.1f} mm off, {correction.normalised_residual:.2f} standard deviations"
        )
    print(f"{100.0 * trace.estimate.unexplained_fraction:.1f} % of the cloud is unexplained")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
