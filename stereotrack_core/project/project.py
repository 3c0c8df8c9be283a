"""The project of a recording: everything that people did to it, in one file."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import astuple
from pathlib import Path

from stereotrack_core.annotation.agreement import click_sigmas
from stereotrack_core.annotation.click import USUAL_SIGMA, Progress
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.locks import now, user
from stereotrack_core.project import schema
from stereotrack_core.project.clicks import Clicks
from stereotrack_core.project.database import copy_whole, make_database
from stereotrack_core.project.edit import Edit, Stamp
from stereotrack_core.project.entries import Entries, ViewSettings, load_landmark_set, load_subject
from stereotrack_core.project.history import Changed, History
from stereotrack_core.project.marks import Marks
from stereotrack_core.project.opening import Opened, open_for_reading, open_for_writing
from stereotrack_core.project.predictions import Predictions, StoredKeypoints
from stereotrack_core.project.whereabouts import (
    RecordingPlace,
    Whereabouts,
    find_recording,
    place_of,
)
from stereotrack_core.recording.description import Subject

Listener = Callable[[Changed], None]


class Project:
    """An open project. All changes go through :meth:`apply`, and are saved when it returns.

    Methods may be called from every thread; listeners are called on the thread of the edit. `notes`
    are remarks on opening it, `who` is the annotator. References, runs, subjects, landmark sets and
    parameter sets are named entries; ``entries.py`` and ``runs.py`` make typed values of them.

    Examples
    --------
    >>> with Project.create(Path("mine.stereotrack"), Path("recording")) as project:
    ...     project.apply(keep_run("first", read_run(Path("run.npz"))))
    """

    def __init__(self, opened: Opened, who: str = "") -> None:
        self._access, self._resources = opened.access, opened.resources
        self.path, self.read_only, self.notes = self._access.path, opened.read_only, opened.notes
        self.who = who or user()
        self.history = History(self._access)
        self._listeners: list[Listener] = []
        self.clicks = Clicks(self._access)
        self.predictions = Predictions(self._access)
        self.keypoints = StoredKeypoints(self._access)
        self.marks = Marks(self._access)
        self.view_settings = ViewSettings(self._access)
        self.references = Entries(schema.REFERENCE, self._access)
        self.runs = Entries(schema.RUN, self._access)
        self.subjects = Entries(schema.SUBJECT, self._access)
        self.landmark_sets = Entries(schema.LANDMARK_SET, self._access)
        self.parameter_sets = Entries(schema.PARAMETER_SET, self._access)
        self.scenarios = Entries(schema.SCENARIO, self._access)
        self.subject()  # refuses one that makes no sense, and the set likewise
        self.landmark_set()

    @staticmethod
    def create(path: Path, recording: Path, *, who: str = "") -> Project:
        """Make a project of a recording folder and open it. Raises InputError."""
        path = path.resolve()
        place = place_of(recording, path)
        make_database(path, astuple(place))
        return Project.open(path, who=who)

    @staticmethod
    def open(
        path: Path, *, read_only: bool = False, take_over: bool = False, who: str = ""
    ) -> Project:
        """Open a project; see :func:`open_for_writing` and :func:`open_for_reading`."""
        path = path.resolve()
        opened = (
            open_for_reading(path) if read_only else open_for_writing(path, take_over=take_over)
        )
        try:
            return Project(opened, who)
        except BaseException:
            opened.resources.close()
            raise

    def close(self) -> None:
        """Give the file back; a second time does nothing."""
        with self._access.for_nobody_else():
            self._listeners.clear()
            self._resources.close()

    def __enter__(self) -> Project:
        """The project itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def apply(self, edit: Edit, *, continues: bool = False) -> Changed | None:
        """Make an edit; it is saved when this returns. None where it changes nothing.

        One that continues the last edit becomes one with it, as when a click is nudged again.
        Raises InputError where it makes no sense or cannot be saved.
        """
        stamp = Stamp(self.who, now())
        return self._changing(lambda: self.history.apply(edit, stamp, continues=continues))

    def undo(self) -> Changed | None:
        """Take the last edit back, however long ago it was made; None where there is none."""
        return self._changing(self.history.undo)

    def redo(self) -> Changed | None:
        """Make the edit again that was taken back last; None where there is none."""
        return self._changing(self.history.redo)

    def on_change(self, listener: Listener) -> Callable[[], None]:
        """Call `listener` after every change; the function returned ends that.

        What it raises comes out of the edit, which is saved, after all others were called.
        """
        self._listeners.append(listener)

        def forget() -> None:
            if listener in self._listeners:
                self._listeners.remove(listener)

        return forget

    def chosen(self, entries: Entries) -> str | None:
        """Name of the one that is used (:class:`entries.Choose`); None where none is."""
        row = self._access.read(schema.CHOICE, (entries.table.name,))
        name = None if row is None else str(row[0])
        return name if name in entries.names() else None

    def subject(self) -> Subject | None:
        """The subject that was chosen."""
        name = self.chosen(self.subjects)
        return None if name is None else load_subject(self.subjects, name)

    def landmark_set(self) -> LandmarkSet:
        """The set of landmarks that was chosen; the nine where none was."""
        return load_landmark_set(self.landmark_sets, self.chosen(self.landmark_sets))

    def click_sigmas(self, usual: float = USUAL_SIGMA) -> dict[str, float]:
        """Sigma of a click, pixels per axis, by landmark, measured by repeats, else `usual`."""
        return click_sigmas(self.clicks.repeat_differences(), self.landmark_set().names, usual)

    def progress(self) -> Progress:
        """Keyframes done and flagged; "214 of 300 keyframes, 3 flagged"."""
        keyframes = {one.frame: one.done for one in self.marks.keyframes()}
        flagged = {one.frame for one in self.marks.flags()} | self.clicks.doubted_frames()
        flags = len(keyframes.keys() & flagged)
        return Progress(len(keyframes), sum(keyframes.values()), flags, self.clicks.count())

    def recording_place(self) -> RecordingPlace:
        """Where the project saw its recording last. Raises InputError without one."""
        place = self._place()
        if place is None:
            what = "the project does not state its recording"
            raise InputError(what, self.path, "Choose the recording's folder.")
        return place

    def _place(self) -> RecordingPlace | None:
        row = self._access.row("SELECT name, relative, absolute, fingerprint FROM recording")
        return None if row is None else RecordingPlace(*row)

    def find_recording(self, folders: Iterable[Path] = ()) -> Whereabouts:
        """Look for the recording, in these folders too; a new place is remembered."""
        place = self._place()
        if place is None:
            what = "the recording of the project is not known"
            remedy = "Choose the recording's folder."
            return Whereabouts(None, Finding("error", str(self.path), what, remedy))
        found = find_recording(place, self.path, folders)
        if found.folder is not None and not self.read_only:
            new = place_of(found.folder, self.path)
            if new.fingerprint == place.fingerprint and new != place:
                self._remember(new)
        return found

    def use_recording(self, folder: Path, *, even_another: bool = False) -> None:
        """Take the recording from this folder from now on. Raises InputError."""
        place = place_of(folder, self.path)
        known = self._place()
        if not (even_another or known is None or place.fingerprint == known.fingerprint):
            remedy = "Choose another folder, or confirm that this one is to be used anyway."
            raise InputError("this is not the recording of the project", folder, remedy)
        self._remember(place)

    def save_copy(self, path: Path) -> None:
        """Write the project to another file, even if its own has vanished. Raises InputError."""
        path = path.resolve()
        if path == self.path:
            remedy = "It is already saved. Choose another file for a copy."
            raise InputError("this is the project itself", path, remedy)
        with self._access.alone() as database:
            copy_whole(database, path)

    def _changing(self, change: Callable[[], Changed | None]) -> Changed | None:
        if self.read_only:
            remedy = "Open it for writing, or work on a copy of it."
            raise InputError("the project is open read-only", self.path, remedy)
        with self._access.at_once():
            changed = change()
            if changed is not None:
                with ExitStack() as stack:  # goes on where a listener raises something
                    for listener in reversed(self._listeners):
                        stack.callback(listener, changed)
        return changed

    def _remember(self, place: RecordingPlace) -> None:
        with self._access.writing() as database:
            database.execute(
                "INSERT OR REPLACE INTO recording VALUES (1, ?, ?, ?, ?)", astuple(place)
            )
