"""``stereotrack cloud``: the fused point cloud of one frame as a file."""

from argparse import Namespace
from contextlib import closing

import numpy as np

from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.volume import settled
from stereotrack_core.interop.ply import write_cloud
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views, views_of
from stereotrack_core.tables import Table
from stereotrack_core.tracking.presets import preset


@options.command(
    options.RECORDING,
    options.option("--frame N", "frame, counted from 0", type=int, required=True),
    options.output("cloud.ply", "file to write", ".ply"),
    options.VIEWS,
    *options.SETTINGS,
)
def run(args: Namespace) -> int:
    """Write the fused point cloud of one frame as a binary PLY file: metres in the world
    frame, with the view of each point as a number and as a colour.
    """
    recording = open_recording(args.recording)
    settings = preset(args.preset, args.changes)
    views = usable_views(recording, views_of(recording, args.views))
    with FrameReader(recording, views=views, colour=False) as reader:
        frame_set = reader.frame_set(args.frame)
        depth = settled(recording, settings.depth, reader, views)
        with closing(DepthChain(recording, depth, views=views)) as chain:
            chain.learn_background(reader, range(reader.frame_count))
            cloud = chain.process(frame_set)
    write_cloud(args.output, cloud.points, cloud.view, cloud.view_names, cloud.frame)
    counts = np.bincount(cloud.view, minlength=len(cloud.view_names)).tolist()
    for problem in cloud.problems.values():
        say(problem)
    facts = {
        "cloud": args.output,
        "frame": cloud.frame,
        "points": len(cloud.points),
        "points_of_view": dict(zip(cloud.view_names, counts, strict=True)),
        "problems": cloud.problems,
    }
    rows = [(name, str(count)) for name, count in facts["points_of_view"].items()]
    rows.append(("all", str(len(cloud.points))))
    table = Table(f"Frame {cloud.frame} in {args.output}", ("view", ">points"), rows)
    put_result(facts, table, as_json=args.json)
    return OK
