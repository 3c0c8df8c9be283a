"""Small scenes for the tests of this room, each built once."""

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

from stereotrack_core.simulation.make import Simulation, build_scene
from stereotrack_core.simulation.motions import parts_of, scheduled
from stereotrack_core.simulation.rig import SceneOptions

SMALL = {"width": 160, "height": 120, "focal": 100.0}


def scene(person="P2", motions=("t-pose",), frames=2, views=("N",), seed=0, **options):
    chosen = tuple((SMALL | options).items())
    return _scene(person, "+".join(motions), frames, "".join(views), seed, chosen)


@lru_cache(maxsize=12)
def _scene(person, motion, frames, views, seed, options):
    made = Simulation(person, motion, frames, views, seed, SceneOptions(**dict(options)))
    with ThreadPoolExecutor(2) as workers:
        return build_scene(made, workers)


def chain(person, names, frames, **options):
    """States and segments of motions that follow one another."""
    return scheduled(person, parts_of(names, frames, SceneOptions(**options)), frames)
