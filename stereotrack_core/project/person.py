"""Where a project's clicks, reference and newest run show the person."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import load_run
from stereotrack_core.recording.description import Recording


def person_pixels(recording: Recording, project: Project | None) -> dict[str, FloatArray]:
    """Pixels (N, 2) of each view's reference image at which landmarks were clicked or found.

    Besides the project's, those of the recording's own reference. What cannot be read is told by
    those who show it, and left out here.
    """
    places = _landmarks(recording, project)
    clicked: dict[str, list[tuple[float, float]]] = {}
    for click in () if project is None else project.clicks.all():
        if click.position is not None:
            clicked.setdefault(click.camera, []).append(click.position)
    found = {}
    for view in recording.views:
        camera = recording.reference_camera(view)
        pixels = np.array(clicked.get(camera.name, ()), dtype=np.float64).reshape(-1, 2)
        found[view.name] = np.concatenate([pixels, camera.project(places)])
    return found


def _landmarks(recording: Recording, project: Project | None) -> FloatArray:
    """Landmarks (N, 3) of all frames that are known, world, metres."""
    trajectories = [] if recording.reference is None else [recording.reference.points]
    if project is not None:
        with suppress(InputError):
            name = project.chosen(project.references)
            if name is not None:
                trajectories.append(load_reference(project.references, name).trajectory().points)
        with suppress(InputError):
            newest = project.runs.names()[-1:]
            trajectories += [load_run(project.runs, one).landmarks for one in newest]
    every = [points.reshape(-1, 3) for points in trajectories] or [np.empty((0, 3))]
    result: FloatArray = np.concatenate(every)
    return result[np.isfinite(result).all(axis=1)]
