"""``stereotrack detect``: keypoints of the person, by the installed detector or another model."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from stereotrack_core.cli.arguments import (
    FRAMES,
    JSON,
    RECORDING,
    VIEWS,
    check_output,
    check_suffix,
    option,
)
from stereotrack_core.cli.output import FAILED, OK, put_result, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.locks import writing
from stereotrack_core.pose_model.detect import detect_keypoints
from stereotrack_core.pose_model.detector import required_detector
from stereotrack_core.pose_model.onnx_model import PoseModel
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.keypoint_names import LAYOUTS
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within, views_of
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Detect keypoints of the person in all pictures with the pretrained detector (`stereotrack "
    "detector install`), or with a pose model of yours (ONNX): RTMPose and other SimCC models, or "
    "models with heat maps. The keypoints are used with `stereotrack track --keypoints`, or "
    "imported with `stereotrack import predictions`."
)

OPTIONS = (
    RECORDING,
    option(
        "--model FILE", "pose model of one person, .onnx (default: the installed one)", type=Path
    ),
    option("-o --output FILE", "table of keypoints to write (.csv)", type=Path, required=True),
    option(
        "--layout",
        "order of the points of your model (default: by their number)",
        choices=tuple(LAYOUTS),
    ),
    FRAMES,
    VIEWS,
    JSON,
)


def run(args: Namespace) -> int:
    """Detect and write."""
    check_suffix(args.output, ".csv")
    if args.model is None and args.layout is not None:
        raise InputError(
            "the installed detector's points have names",
            where="--layout",
            remedy="Omit it, or give --model.",
        )
    recording = open_recording(args.recording)
    check_output(args.output, recording)
    with writing(args.output):
        return _detect(args, recording)


def detected_in_views(
    recording: Recording, asked: str | None, views: Sequence[str] | None
) -> Keypoints:
    """Keypoints by the installed detector, with progress.

    Parameters
    ----------
    asked : str, optional
        Frames as the command line states them.
    """
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        frames = frames_within(asked, reader.frame_count)
    with progress("Detecting", len(frames)) as show:
        return detect_keypoints(recording, required_detector(), frames, views=views, on_frame=show)


def _detect(args: Namespace, recording: Recording) -> int:
    views = views_of(recording, args.views)
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        frames = frames_within(args.frames, reader.frame_count)
    model = required_detector() if args.model is None else PoseModel(args.model)
    with progress("Detecting", len(frames)) as show, stoppable() as stopped:
        keypoints = detect_keypoints(
            recording, model, frames, views=views, layout=args.layout, on_frame=show,
            cancelled=stopped,
        )  # fmt: skip
        ended = stopped()
    write_table(args.output, keypoints, recording)
    done = len(set(keypoints.frame.tolist()))
    facts = {
        "keypoints": len(keypoints),
        "frames": done,
        "of_frames": len(frames),
        "cameras": ", ".join(keypoints.cameras),
        "mean_confidence": round(float(keypoints.confidence.mean()), 3),
        "file": str(args.output),
    }
    rows = [(name.replace("_", " "), str(value)) for name, value in facts.items()]
    put_result(facts, Table(recording.name, ("", ">"), rows), as_json=args.json)
    if ended:
        say(f"Stopped. The keypoints of {counted(done, 'frame')} are in {args.output}.")
    return FAILED if ended else OK
