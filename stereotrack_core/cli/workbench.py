"""``stereotrack open``: the window on a recording folder or a project file."""

from argparse import Namespace

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, say
from stereotrack_core.errors import InputError
from stereotrack_core.window import Opening, ShowWindow


@options.command(
    options.path(
        "path PATH", "recording folder, project file, run, study file or folder of videos"
    ),
    options.option(
        "--workspace NAME",
        "annotate, track, review, tune or calibrate (default: the last one used)",
    ),
    options.option(
        "--frame N",
        "frame to start at, counted from 0 (default: the last one shown)",
        type=int,
        default=0,
    ),
    options.path(
        "--screenshot PNG", "save a screenshot of the window and exit; works without a display"
    ),
    json=False,
)
def run(args: Namespace) -> int:
    """Open the workbench on a recording folder, a project file, a run, which is shown with
    its recording, or a study. For a folder of videos it offers to make a recording.
    """
    opening = Opening(args.path, args.frame, args.workspace, picture=args.screenshot)
    return show_window(args.window, opening)


def show_window(window: ShowWindow | None, opening: Opening) -> int:
    """Show the window; return the exit status. InputError where there is none to show."""
    if window is None:
        what = "the workbench cannot be started here"
        raise InputError(what, remedy="Start it with the program `stereotrack`.")
    return OK if window(opening, say) else FAILED
