"""How good a project's clicks are, measured by frames that were annotated again blindly."""

from __future__ import annotations

from stereotrack_core.annotation.agreement import Difference, click_sigmas, differences
from stereotrack_core.project.project import Project


def repeat_differences(project: Project) -> tuple[Difference, ...]:
    """First against second readings of the frames that were annotated again, round by round."""
    found: list[Difference] = []
    for number in project.clicks.rounds():
        second = project.clicks.again(number)
        frames = sorted({click.frame for click in second})
        first = [click for frame in frames for click in project.clicks.at(frame)]
        found.extend(differences(first, second))
    return tuple(found)


def measured_sigmas(project: Project, usual: float) -> dict[str, float]:
    """Standard deviation of a click in pixels per axis, for each landmark of the project's set.

    Parameters
    ----------
    usual : float
        What is assumed while little was annotated again.
    """
    names = project.landmark_set().names
    return click_sigmas(repeat_differences(project), names, usual)
