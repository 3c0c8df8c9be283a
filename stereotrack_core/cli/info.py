"""``stereotrack info``: what a recording holds, and what looks wrong about it."""

from argparse import Namespace
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, WRONG_INPUT, put, put_json, put_table, say
from stereotrack_core.counting import counted
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import WorkingSpace, check_reach, working_space
from stereotrack_core.doctor.correcting import correct_all, words_of
from stereotrack_core.doctor.diagnose import diagnose
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.detections import own_detections
from stereotrack_core.recording.findings import Finding, by_severity, examine
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tables import Table
from stereotrack_core.tracking.presets import preset


@options.command(
    options.RECORDING,
    options.flag("--deep", "also check images, stereo pairs, clocks and depths; takes longer"),
    options.flag(
        "--correct",
        "with --deep: correct in the recording's files what has one mechanical cause; the file "
        "before is kept beside, and nothing is changed where the problem would remain",
    ),
    *options.SETTINGS,
)
def run(args: Namespace) -> int:
    """Print what a recording contains and all problems found in it, with file, key and
    remedy. The exit status is 2 if the recording has errors.
    """
    folder: Path = args.recording
    if not folder.is_dir():
        what = "this is a file" if folder.is_file() else "there is no such folder"
        raise InputError(what, folder, "Give the folder that contains recording.toml.")
    if args.correct and not args.deep:
        raise InputError("corrections need what is measured", "--correct", "Add --deep.")
    depth = preset(args.preset, args.changes).depth
    measured: tuple[Finding, ...] = ()
    if args.deep:
        with suppress(InputError):  # told by the other checks
            measured = diagnose(open_recording(folder))
    corrected = []
    if args.correct:
        found = by_severity((*examine(folder, compare=True), *measured))
        for done in correct_all(folder, found, say):
            corrected.append(done)
            measured = done.measured
    content = _content(folder, depth)
    space: WorkingSpace | None = None if content is None else content["working_space"]
    reach = check_reach(space) if space is not None else ()
    findings = by_severity((*examine(folder, deep=args.deep), *measured, *reach))
    if args.json:
        told = {"corrected": corrected} if args.correct else {}
        put_json({"folder": folder, "content": content, "findings": findings, **told})
    else:
        _print(content, findings)
    errors = Counter(finding.severity for finding in findings)["error"]
    if errors:
        say(f"{counted(errors, 'error')} in {folder}.")
    return WRONG_INPUT if errors else OK


def _content(folder: Path, depth: DepthParameters) -> dict[str, Any] | None:
    """What the recording holds; None where it cannot be opened (the findings say why)."""
    try:
        recording = open_recording(folder)
        detections = own_detections(recording)
        with FrameReader(recording, read_ahead=0) as reader:
            frames = reader.frame_count
            counts = reader.stream_counts()
            space: WorkingSpace | None = None
            if frames and not recording.guessed:
                with suppress(InputError):  # no depth can be measured
                    space = working_space(recording, depth, reader, usable_views(recording, None))
    except InputError:
        return None
    return {
        "name": recording.name,
        "frames": frames,
        "fps": recording.fps,
        "seconds": frames / recording.fps,
        "views": [_view(recording, view, counts) for view in recording.views],
        "subject": recording.subject,
        "reference_frames": None if recording.reference is None else len(recording.reference.frame),
        "segments": recording.segments,
        "detections": None if detections is None else len(detections),
        "working_space": space,
    }


def _view(recording: Recording, view: View, counts: Any) -> dict[str, Any]:
    camera = recording.reference_camera(view)
    baseline = None
    if view.left is not None:
        other = recording.cameras[view.left.camera].position_world
        baseline = float(((other - camera.position_world) ** 2).sum() ** 0.5)
    return {
        "name": view.name,
        "kind": view.kind,
        "size": [camera.width, camera.height],
        "focal_px": float(camera.matrix[0, 0]),
        "baseline_m": baseline,
        "position_m": camera.position_world,
        "background": view.image.background is not None,
        "mask": view.mask is not None,
        "frames": {
            key: counts[view.name, key] for key in view.streams() if (view.name, key) in counts
        },
    }


def _print(content: dict[str, Any] | None, findings: tuple[Finding, ...]) -> None:
    if content is not None:
        put_table(Table(content["name"], ("what", "value"), _facts(content)))
        headings = ("view", "kind", ">size", ">focal", ">base line", ">place (m)", ">frames", "has")
        put_table(Table("Views", headings, [_view_row(view) for view in content["views"]]))
        space: WorkingSpace | None = content["working_space"]
        if space is not None:
            rows = [("up", f"{space.up_axis} of the world"), ("working volume", space.volume)]
            rows += [(f"disparities of {one}", space.searched(one)) for one in space.disparities_px]
            put_table(Table("Where the person is looked for", ("what", "value"), rows))
    if findings:
        listed = [(f.severity, f.where, f.what, _remedy(f)) for f in findings]
        put_table(Table("Recording checks", ("severity", "where", "what", "remedy"), listed))
    else:
        put("No problems found.")


def _remedy(finding: Finding) -> str:
    """What to do, and what ``--correct`` would."""
    if finding.correction is None:
        return finding.remedy
    return f"{finding.remedy} [--correct: {words_of(finding.correction)}]"


def _facts(content: dict[str, Any]) -> list[tuple[str, str]]:
    frames, fps = content["frames"], content["fps"]
    rows = [("frames", f"{frames} at {fps:g} Hz, {content['seconds']:.1f} s")]
    subject = content["subject"]
    told = "none, average proportions"
    if subject is not None:
        fields = [name for name in vars(subject) if name != "name"]
        measured = [name for name in fields if getattr(subject, name) is not None]
        told = f"{subject.name or 'unnamed'}, {len(measured)} of {len(fields)} lengths measured"
    rows.append(("subject", told))
    known = content["reference_frames"]
    rows.append(("reference", "none" if known is None else f"{known} frames"))
    segments = [f"{s.name} {s.first}:{s.end}" for s in content["segments"]]
    rows.append(("segments", ", ".join(segments) or "none"))
    if content["detections"] is not None:
        rows.append(("detections", str(content["detections"])))
    return rows


def _view_row(view: dict[str, Any]) -> tuple[str, ...]:
    counts = sorted(set(view["frames"].values()))
    has = [word for word in ("background", "mask") if view[word]]
    base = view["baseline_m"]
    return (
        view["name"],
        view["kind"],
        "{} x {}".format(*view["size"]),
        f"{view['focal_px']:.0f} px",
        "-" if base is None else f"{1000 * base:.0f} mm",
        " ".join(f"{value:.2f}" for value in view["position_m"]),
        " / ".join(str(count) for count in counts),
        ", ".join(has),
    )
