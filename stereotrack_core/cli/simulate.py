"""``stereotrack simulate``: a rendered recording with truth."""

from argparse import Namespace

from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, put_facts, watched
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions


@options.command(
    options.path("folder DIR", "new folder for the recording"),
    options.option("--person NAME", "P1 to P4 (default: P1)", default="P1"),
    options.option(
        "--motion NAME",
        "named motion, or several joined by + (default: cross-arms); an unknown name prints "
        "the list",
        default="cross-arms",
    ),
    options.option("--frames N", "number of frames (default: 120)", type=int, default=120),
    options.option("--views NS", "view names without separator (default: NOSW)", default="NOSW"),
    options.SEED,
    options.changes("change a scene parameter, for example clothes=plain or shadow=0.3"),
)
def run(args: Namespace) -> int:
    """Render a recording of a simulated person in stereo views. The true landmarks are its
    reference, the named motions its segments.
    """
    facts = {name: getattr(args, name) for name in ("person", "motion", "frames", "views", "seed")}
    scene = SceneOptions().replaced(**parsed_settings(args.changes))
    with watched("Rendering", "No recording was created.") as work:
        simulate(args.folder, Simulation(**facts, options=scene), work)
    facts["fps"] = scene.fps
    title = f"Recording written to {args.folder}"
    put_facts(facts, title, as_json=args.json, recording=args.folder)
    return OK
