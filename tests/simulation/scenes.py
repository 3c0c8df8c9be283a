"""Small scenes for the tests of this room."""

from concurrent.futures import ThreadPoolExecutor

from stereotrack_core.simulation.make import build_scene
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.rig import SceneOptions

SMALL = {"width": 160, "height": 120, "focal": 100.0}


def scene(
    person="P2", motions=("t-pose",), frames=2, views=("N",), seed=0, disturbances=(), **options
):
    chosen = SceneOptions(**(SMALL | options))
    with ThreadPoolExecutor(2) as workers:
        return build_scene(
            PEOPLE[person], motions, frames, views, seed, chosen, workers, (), disturbances
        )
