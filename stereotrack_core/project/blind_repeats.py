"""Frames that are annotated a second time, without showing what was clicked the first time."""

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.counting import counted
from stereotrack_core.project.project import Project

_FRAME = "repeats.frame"


class BlindRepeats:
    """Keeps the second reading of a frame, the `active` one, apart from the first.

    What is under way is kept in the project, also while the program is closed.
    """

    def __init__(self, project: Project) -> None:
        self._project = project
        frame = project.view_settings.get(_FRAME)
        self.active: int | None = frame if isinstance(frame, int) else None

    def begin(self, frame: int | None) -> None:
        """Annotate a frame again from now on; None shows everything, and keeps what was clicked."""
        self.active = frame
        self._project.view_settings.set(_FRAME, frame)

    def clicks(self) -> tuple[Click, ...]:
        """The second reading of the frame so far."""
        return () if self.active is None else self._project.clicks.again_at(self.active)

    def missing(self) -> tuple[ClickKey, ...]:
        """Clicks of the first reading of the frame that the second one lacks."""
        if self.active is None:
            return ()
        there = {click.key for click in self.clicks()}
        first = self._project.clicks.at(self.active)
        return tuple(sorted(click.key for click in first if click.key not in there))

    def words(self) -> str:
        """Progress of the repeat for the person who clicks; empty if none is under way."""
        if self.active is None:
            return ""
        return (
            f"Blind repeat of frame {self.active}: {counted(len(self.clicks()), 'click')} done, "
            f"{len(self.missing())} to go. Earlier clicks are hidden."
        )
