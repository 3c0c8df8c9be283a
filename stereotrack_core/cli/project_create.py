"""``stereotrack project create``: a project file of a recording."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.annotation.landmark_set import read_landmark_set
from stereotrack_core.cli.arguments import JSON, RECORDING, check_output, check_suffix, option
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.errors import InputError
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import LANDMARK_SET
from stereotrack_core.project.setups import save_landmark_set
from stereotrack_core.project.whereabouts import SUFFIX, project_path_for
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Make a project of a recording: the file that keeps clicks, references and runs. Labels come "
    "in with `stereotrack import labels`, and `stereotrack open` shows it."
)

OPTIONS = (
    RECORDING,
    option(
        "-o --output PROJECT",
        f"file to write ({SUFFIX}); by default beside the recording folder, with its name and, "
        "where there is one already, a number",
        type=Path,
    ),
    option("--annotator NAME", "whose clicks and edits they are"),
    option(
        "--landmarks FILE",
        "set of landmarks (.toml) that is clicked; by default the nine",
        type=Path,
    ),
    JSON,
)


def run(args: Namespace) -> int:
    """Make the project; one that is there is left alone."""
    recording = open_recording(args.recording)
    path = args.output or project_path_for(recording.folder)
    check_suffix(path, SUFFIX)
    check_output(path, recording)
    if path.exists():
        raise InputError(
            "there is such a file already",
            where=str(path),
            remedy="Open it with `stereotrack open`, or choose another name with -o.",
        )
    landmarks = None if args.landmarks is None else read_landmark_set(args.landmarks)
    with Project.create(path, recording.folder, who=args.annotator or "") as project:
        if landmarks is not None:
            project.apply(save_landmark_set(landmarks))
            project.apply(Choose(LANDMARK_SET.name, landmarks.name))
        names = project.landmark_set().names
    facts = {"project": path, "recording": recording.folder, "landmarks": list(names)}
    rows = [("recording", str(recording.folder)), ("landmarks", ", ".join(names))]
    put_result(facts, Table(f"{path} was made", ("", ""), rows), as_json=args.json)
    return OK
