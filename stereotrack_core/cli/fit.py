"""``stereotrack fit``: the body fitted to clicks; a subject file from a few clicked frames."""

from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from stereotrack_core.annotation import doubts, personal_subject
from stereotrack_core.annotation.click import Click, ClickKey, Sigmas
from stereotrack_core.annotation.fit.fit import FitRequest, clicks_in, fit_reference
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import origin_of, reference_of_fit
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, progress, put_json, put_table, say, stoppable
from stereotrack_core.cli.sources import clicks_in_file
from stereotrack_core.counting import counted, spread_words
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera_agreement import Disagreement
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.project.exporting import export_reference, format_of_file
from stereotrack_core.recording.description import Recording, write_subject
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import frame_count
from stereotrack_core.recording.selection import check_calibrated, frames_within, views_of
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.repeating import other_files


def _personalise(
    args: Namespace,
    recording: Recording,
    clicks: Sequence[Click],
    settings: FitSettings,
    sigma: Sigmas,
) -> int:
    run = None if args.tracked is None else read_run(args.tracked)
    where = str(args.clicks)
    work = personal_subject.Personalise(
        recording, tuple(clicks), sigma, settings, where, run, args.views
    )
    if not work.by_frame:
        raise InputError("there is no click", where, "Click a few frames first.")
    for sentence in () if run is None else other_files(run, recording):
        say(f"{args.tracked}: {sentence}")
    end = max(work.by_frame) + 1
    with progress("Tracking", end) as show, stoppable("Nothing was written.") as stopped:
        found = work.estimated(lambda frame: show(frame + 1), stopped)
    write_subject(args.output, found.subject)
    _tell_subject(args, found)
    return OK


def _tell_subject(args: Namespace, one: personal_subject.PersonalSubject) -> None:
    if args.json:
        found, torso = one.found, proportions_of(one.subject).torso_length
        degrees, spread = found.lean(torso)
        put_json(
            {
                "subject": args.output,
                "frames": found.frames,
                "left_out": [{"frame": f, "landmark": name} for f, name in found.left_out],
                "offsets_m": dict(zip(LANDMARKS, found.offsets.tolist(), strict=True)),
                "sigma_m": dict(zip(LANDMARKS, found.sigma.tolist(), strict=True)),
                "lean_deg": degrees,
                "lean_sigma_deg": spread,
            }
        )
        return
    put_table(personal_subject.offset_table(one))
    say(personal_subject.lean_words(one))
    for words in personal_subject.left_out_words(one):
        say(words)
    say(f"Written to {args.output}. Name it as subject in recording.toml to use it.")


_LISTED = 20  # probable outliers that are listed one by one


@options.command(
    options.RECORDING,
    options.flag(
        "--personalise",
        "write a subject file instead: where the person's joints lie in the tracked body, from "
        "a few clicked frames",
    ),
    options.path(
        "--run RUN.npz",
        "with --personalise: a run of this recording (default: the recording is tracked up to "
        "the last clicked frame)",
        dest="tracked",
    ),
    options.path(
        "--clicks CSV|PROJECT",
        "clicks: frame,view,landmark,x,y,visibility; or a project",
        required=True,
    ),
    options.output(
        "REFERENCE",
        "output file: .csv (as reference.csv) or .npz (with covariances); with --personalise a "
        "subject file (.toml)",
        *(".csv", ".npz", ".toml"),
    ),
    options.FRAMES,
    options.VIEWS,
    options.option(
        "--sigma PX",
        "standard deviation of a click on a visible landmark, per axis (default: 3, or what "
        "the project has measured)",
        type=options.positive,
    ),
    options.flag("--without-depth", "fit to the clicks alone where the recording has depth"),
)
def run(args: Namespace) -> int:
    """Fit the body to clicked landmarks with a forward and a backward pass over the frames,
    using the recording's depth where available, and write the trajectory as a reference.
    Outliers among the clicks are detected and listed. Frames between clicked ones are
    interpolated.
    """
    options.check_suffix(args.output, *((".toml",) if args.personalise else (".csv", ".npz")))
    recording = open_recording(args.recording)
    check_calibrated(recording)
    settings = FitSettings(use_depth=not args.without_depth)
    views = views_of(recording, args.views)
    count = frame_count(recording, views)
    frames = frames_within(args.frames, count)
    clicks, usual = clicks_in_file(args.clicks, recording, count)
    sigma = args.sigma or usual
    if args.personalise:
        return _personalise(args, recording, clicks, settings, sigma)
    with progress("Reading", len(frames)) as show, stoppable(at_once=True):
        fit = fit_reference(
            recording,
            clicks,
            FitRequest(frames, views, settings, sigma=sigma, source=str(args.clicks)),
            on_frame=lambda frame: show(frame - frames.start + 1),
        )
    meta = origin_of(recording, len(clicks), sigma, settings)
    form = format_of_file(args.output)
    used = clicks_in(recording, clicks, views)
    written = export_reference(args.output, reference_of_fit(fit, meta, used), form, None)
    for note in written.notes:
        say(note)
    _tell(args, fit, recording, used)
    return OK


def _tell(
    args: Namespace, fit: TrajectoryFit, recording: Recording, clicks: Sequence[Click]
) -> None:
    doubtful = doubts.doubtful_camera(clicks, recording.cameras, NINE)
    outliers = doubts.own_outliers(fit.flagged(), doubtful, clicks, recording.cameras)
    residuals = doubts.residuals_by_camera(clicks, recording.cameras, NINE, doubtful)
    facts = _facts(fit, outliers, doubtful)
    facts["cameras"] = {
        r.camera: {"clicks": r.count, "residual_px": r.median_px} for r in residuals
    }
    if args.json:
        put_json({"reference": args.output, **facts})
    else:
        put_table(_table(facts, f"{recording.name} in {args.output}"))
        _say_outliers(fit, outliers, doubtful)


def _facts(
    fit: TrajectoryFit, outliers: Sequence[ClickKey], doubtful: Disagreement | None
) -> dict[str, Any]:
    flagged = set(fit.flagged())
    right = [residual for key, residual in fit.residual_px.items() if key not in flagged]
    known = fit.kind != GAP
    squares = np.square(fit.limb_sigma_deg[known])
    sigma = np.sqrt(squares.mean(axis=0)) if known.any() else np.full(6, np.nan)
    facts = {
        "frames": {kind: int((fit.kind == kind).sum()) for kind in (CLICKED, INTERPOLATED, GAP)},
        "clicks": len(fit.residual_px),
        "residual_px": float(np.sqrt(np.nanmean(np.square(right)))) if right else None,
        "sigma_factor": fit.sigma_factor,
        "limb_sigma_deg": dict(zip(LIMBS, sigma.tolist(), strict=True)),
        "probable_outliers": [_far_off(fit, key) for key in outliers],
        "disagreement": None,
    }
    if doubtful is not None:
        facts["disagreement"] = {
            **asdict(doubtful),
            "clicks_far_off": [_far_off(fit, key) for key in sorted(flagged - set(outliers))],
        }
    return facts


def _far_off(fit: TrajectoryFit, key: ClickKey) -> dict[str, Any]:
    off = float(np.linalg.norm(fit.residual_px[key]))
    return {**key._asdict(), "residual_px": off, "probability": fit.outlier_probability[key]}


def _table(facts: Mapping[str, Any], title: str) -> Table:
    rows = [(f"frames {kind}", str(count)) for kind, count in facts["frames"].items()]
    rows += [
        ("clicks", str(facts["clicks"])),
        ("probable outliers", str(len(facts["probable_outliers"]))),
        ("residual of clicks, per axis", f"{number(facts['residual_px'] or np.nan)} px"),
        ("scatter of clicks relative to their sigma", number(facts["sigma_factor"], 2)),
    ]
    rows += [
        (f"residual of clicks in {camera}, median", f"{number(one['residual_px'])} px")
        for camera, one in facts["cameras"].items()
    ]
    limbs = facts["limb_sigma_deg"].items()
    rows += [(f"uncertainty {n.replace('_', ' ')}", spread_words(d, " deg")) for n, d in limbs]
    return Table(title, ("what", ">value"), rows)


def _say_outliers(
    fit: TrajectoryFit, outliers: Sequence[ClickKey], doubtful: Disagreement | None
) -> None:
    if doubtful is not None:
        count = counted(len(fit.flagged()) - len(outliers), "click")
        say(f"{doubts.what_disagrees(doubtful)}. {doubts.what_to_do(doubtful)}")
        say(f"{count} outliers may be due to that. Use --views to leave the view out.")
    for key in outliers[:_LISTED]:
        off = float(np.linalg.norm(fit.residual_px[key]))
        place = f"frame {key.frame}, {key.camera}, {key.landmark}"
        say(f"{place}: {off:.0f} px from the fit, probable outlier")
    if len(outliers) > _LISTED:
        say(f"and {len(outliers) - _LISTED} more; --json lists all of them")
