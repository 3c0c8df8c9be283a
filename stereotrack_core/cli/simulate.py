"""``stereotrack simulate``: a rendered recording with truth."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import add_changes, add_json
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import Table, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.errors import Cancelled


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="new folder for the recording")
    parser.add_argument("--person", default="P1", metavar="NAME", help="P1 to P4 (default: P1)")
    parser.add_argument(
        "--motion",
        default="cross-arms",
        metavar="NAME",
        help="named motion, or several joined by + (default: cross-arms); an unknown name prints "
        "the list",
    )
    parser.add_argument(
        "--frames", type=int, default=120, metavar="N", help="number of frames (default: 120)"
    )
    parser.add_argument(
        "--views", default="NOSW", metavar="NS", help="view names without separator (default: NOSW)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="random seed (default: 0)")
    add_changes(parser, "change a scene parameter, for example clothes=plain")
    add_json(parser)


def run(args: Namespace) -> int:
    """Render the recording."""
    from stereotrack_core.parameters import parsed_settings
    from stereotrack_core.simulation.make import simulate
    from stereotrack_core.simulation.options import SceneOptions

    options = SceneOptions().replaced(**parsed_settings(args.changes))
    with progress("Rendering", args.frames) as show, stoppable() as stopped:
        try:
            simulate(
                args.folder,
                person=args.person,
                motion=args.motion,
                frames=args.frames,
                views=args.views,
                seed=args.seed,
                options=options,
                on_progress=lambda done, _: show(done),
                cancelled=stopped,
            )
        except Cancelled:
            say("Stopped. No recording was created.")
            return FAILED
    facts = {name: getattr(args, name) for name in ("person", "motion", "frames", "views", "seed")}
    facts["fps"] = options.fps
    if args.json:
        put_json({"recording": args.folder, **facts})
    else:
        rows = [(name, str(value)) for name, value in facts.items()]
        put_table(Table(f"Recording written to {args.folder}", ("what", "value"), rows))
    return OK


COMMAND = Command(
    name="simulate",
    summary="render a stereo recording with ground truth",
    description=(
        "Render a stereo recording of a simulated person, with the true landmarks as its "
        "reference and the named motions as its segments."
    ),
    add_arguments=add_arguments,
    run=run,
)
