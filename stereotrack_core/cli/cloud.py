"""``stereotrack cloud``: the fused point cloud of one frame as a file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

import numpy as np

from stereotrack_core.cli.arguments import (
    add_json,
    add_recording,
    add_settings,
    add_views,
    check_output,
)
from stereotrack_core.cli.command import OK, Command
from stereotrack_core.cli.output import Table, put_json, put_table, say
from stereotrack_core.errors import InputError
from stereotrack_core.recording.selection import views_of


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument(
        "--frame", type=int, required=True, metavar="N", help="frame, counted from 0"
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="cloud.ply", help="file to write"
    )
    add_views(parser)
    add_settings(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Make the cloud and write it."""
    from stereotrack_core.depth.chain import DepthChain
    from stereotrack_core.interop.ply import write_cloud
    from stereotrack_core.recording.folder import open_recording
    from stereotrack_core.recording.reader import FrameReader
    from stereotrack_core.recording.selection import usable_views
    from stereotrack_core.tracking.presets import preset

    if args.output.suffix.lower() != ".ply":
        raise InputError(
            "only .ply files can be written", where="-o", remedy="Use a name that ends in .ply."
        )
    recording = open_recording(args.recording)
    check_output(args.output, recording)
    settings = preset(args.preset, args.changes)
    views = usable_views(recording, views_of(recording, args.views))
    with FrameReader(recording, views=views, colour=False) as reader:
        frame_set = reader.frame_set(args.frame)
        chain = DepthChain(recording, settings.depth, views=views)
        try:
            chain.learn_background(reader, range(reader.frame_count))
            cloud = chain.process(frame_set)
        finally:
            chain.close()
    write_cloud(args.output, cloud.points, cloud.view, cloud.view_names, cloud.frame)
    counts = np.bincount(cloud.view, minlength=len(cloud.view_names)).tolist()
    for problem in cloud.problems.values():
        say(problem)
    if args.json:
        put_json(
            {
                "cloud": args.output,
                "frame": cloud.frame,
                "points": len(cloud.points),
                "points_of_view": dict(zip(cloud.view_names, counts, strict=True)),
                "problems": cloud.problems,
            }
        )
        return OK
    rows = [(name, str(count)) for name, count in zip(cloud.view_names, counts, strict=True)]
    rows.append(("all", str(len(cloud.points))))
    put_table(Table(f"Frame {cloud.frame} in {args.output}", ("view", ">points"), rows))
    return OK


COMMAND = Command(
    name="cloud",
    summary="the fused point cloud of one frame as a PLY file",
    description=(
        "Write the fused point cloud of one frame as a binary PLY file: metres in the world "
        "frame, with the view of each point as a number and as a colour."
    ),
    add_arguments=add_arguments,
    run=run,
)
