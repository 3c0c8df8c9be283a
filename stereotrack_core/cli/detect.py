"""``stereotrack detect`` and ``detector``: the installed detector, or another model."""

from argparse import Namespace
from collections.abc import Sequence
from itertools import takewhile
from typing import Any

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, progress, put_facts, put_result, say, stoppable
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.reading import write_table
from stereotrack_core.pose_model.detect import detect_keypoints
from stereotrack_core.pose_model.detector import required_detector
from stereotrack_core.pose_model.installation import (
    HEAVY,
    LICENCE,
    MODEL_FILES,
    SOURCE,
    Installation,
    install,
    installation,
)
from stereotrack_core.pose_model.onnx_model import PoseModel
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.keypoint_names import LAYOUTS
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader, frame_count, reference_pictures
from stereotrack_core.recording.selection import frames_within, views_of
from stereotrack_core.tables import Table


@options.command(
    options.RECORDING,
    options.path("--model FILE", "pose model of one person, .onnx (default: the installed one)"),
    options.output("FILE", "table of keypoints to write (.csv)", ".csv"),
    options.option(
        "--layout",
        "order of the points of your model (default: by their number)",
        choices=tuple(LAYOUTS),
    ),
    options.FRAMES,
    options.VIEWS,
)
def run(args: Namespace) -> int:
    """Detect keypoints of the person in all pictures with the pretrained detector
    (`stereotrack detector install`), or with a pose model of yours (ONNX): RTMPose and other
    SimCC models, or models with heat maps. The keypoints are used with `stereotrack track
    --keypoints`, or imported with `stereotrack import predictions`.
    """
    if args.model is None and args.layout is not None:
        what = "the installed detector's points have names"
        raise InputError(what, "--layout", "Omit it, or give --model.")
    recording = open_recording(args.recording)
    views = views_of(recording, args.views)
    frames = frames_within(args.frames, frame_count(recording, views))
    model = required_detector() if args.model is None else PoseModel(args.model, args.layout)
    with progress("Detecting", len(frames)) as show, stoppable() as stopped:
        wanted = takewhile(lambda _: not stopped(), frames)
        with FrameReader(reference_pictures(recording), views=views) as reader:
            keypoints = detect_keypoints(reader, model, wanted, on_frame=show)
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
    put_facts(facts, recording.name, as_json=args.json)
    if ended:
        say(f"Stopped. The keypoints of {counted(done, 'frame')} are in {args.output}.")
    return FAILED if ended else OK


def detected_in_views(
    recording: Recording, asked: str | None, views: Sequence[str] | None
) -> Keypoints:
    """Keypoints by the installed detector, with progress, in frames as options state them."""
    frames = frames_within(asked, frame_count(recording, views))
    pictures = reference_pictures(recording)
    with progress("Detecting", len(frames)) as show, FrameReader(pictures, views=views) as reader:
        return detect_keypoints(reader, required_detector(), frames, on_frame=show)


@options.command(
    options.option(
        "action install", "fetch, check and keep the files", choices=("install",), nargs="?"
    ),
    options.path("source FILE|FOLDER", "wheel, folder or archive to take them from", nargs="?"),
    options.flag(
        "--if-missing", "do nothing if it is installed, and go on without it if it cannot be"
    ),
)
def detector(args: Namespace) -> int:
    """Say whether the pretrained pose detector is installed, or install it: two files of BlazePose
    of MediaPipe (Apache-2.0). `install` downloads the wheel with pip, takes the files out, checks
    them and keeps them in your data folder; `install FILE` takes them from a wheel, or a folder,
    that you have. The archive that `npm pack @mediapipe/pose` fetches adds a larger network, which
    finds arms more exactly, takes twice as long, and is used from then on.
    """
    state = installation()
    if args.action == "install":
        if args.if_missing:
            if set(state.files.values()) != {"installed"}:
                try:
                    install(say=say)
                except InputError as error:
                    say(
                        f"The pose detector is not installed ({error.what}); everything else "
                        "works. Try `stereotrack detector install` later."
                    )
            return OK
        with stoppable() as stopped:
            state = install(args.source, say=say, cancelled=stopped)
    facts: dict[str, Any] = {"installed": state.complete, "folder": str(state.folder)}
    facts |= {"files": dict(state.files), "runtime": state.runtime or None}
    facts |= {"licence": LICENCE, "source": SOURCE}
    put_result(facts, _table(state), as_json=args.json)
    what, remedy = state.problem()
    if what:
        say(f"{what[0].upper()}{what[1:]}. {remedy}")
    return OK


def _table(state: Installation) -> Table:
    files = [one for one in (*MODEL_FILES, HEAVY) if one.name in state.files]
    rows = [(f.name, f.purpose, f"{f.size / 1e6:.1f} MB", state.files[f.name]) for f in files]
    rows += [
        ("ai-edge-litert", "runs them", state.runtime, "installed" if state.runtime else "missing"),
        ("folder", "", "", str(state.folder)),
        ("licence", "", "", LICENCE),
        ("source", "", "", SOURCE),
    ]
    return Table("Pose detector", ("", "", ">", ""), rows)
