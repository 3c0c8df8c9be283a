"""What one step of the tracker did: ``python inspect_step.py RECORDING FRAME``."""

import sys
from pathlib import Path

import stereotrack_core as stereotrack
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.inspection import explain
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.run import advances


def main(folder: Path, frame: int, preset: str = "accurate") -> None:
    recording = stereotrack.open_recording(folder)
    spec = stereotrack.RunSpec(stereotrack.preset(preset))
    with Clouds(recording, spec) as clouds:
        run = prepare(clouds)
        for advance in advances(run, range(frame)):
            run = advance.run
        cloud, _ = clouds.take(frame)
        trace = explain(run.model, run.state, cloud)

    print(f"{frame} frames were tracked before; frame {trace.frame} by {trace.method}")
    for correction in trace.corrections:
        residual_mm = 1000.0 * abs(correction.points.residual).mean()
        print(
            f"  {correction.stage} {correction.iteration}: {len(correction.P_zz)} points, "
            f"{residual_mm:.1f} mm off, {correction.normalised_residual:.2f} standard deviations"
        )
    print(f"{100.0 * trace.estimate.unexplained_fraction:.1f} % of the cloud is unexplained")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
