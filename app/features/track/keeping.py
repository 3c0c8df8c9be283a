"""Runs are stored in the project when they end; stored runs are listed, and read when shown."""

from collections.abc import Callable
from functools import partial
from typing import Any
from weakref import WeakSet

from stereotrack_core.body.model import BodyModel, body_of_subject
from stereotrack_core.errors import InputError
from stereotrack_core.project import runs as project_runs
from stereotrack_core.project.project import Project
from stereotrack_core.tracking.frame import Run, TrackedFrame
from stereotrack_core.tracking.stored import body_of_run

from ...context import Context
from ...session.changes import Part
from ...session.jobs import Job, Task
from ...session.messages import Message
from ...session.runs import RunEntry, frames_of_run

_SHOWN = "runs_shown"


class RunKeeper:
    """Keeps runs in the project, and lists those that it has.

    Entries are changed in the window's thread alone.
    """

    def __init__(self, context: Context) -> None:
        session = context.session
        self._document, self._tasks = session.document, context.tasks
        self._notifier = context.notifier
        self._project, self._runs, self._track = session.project, session.runs, session.track
        self._busy: dict[RunEntry, Task] = {}
        self._tried: WeakSet[RunEntry] = WeakSet()
        self._wanted: WeakSet[RunEntry] = WeakSet()
        self._listed: Project | None = None
        self.removed: list[str] = []  # names of runs that can be restored
        self._soon = context.session.later(self._look, 0)
        watch = session.changes.watch
        facts = Part.PROJECT_OPENED | Part.TRACKING | Part.RUNS | Part.ACTIVE_RUN
        watch(facts, self._soon.start)
        watch(Part.PROJECT_CLOSING, self._keep_what_is_left)
        watch(Part.PROJECT_CLOSED, self._forget)

    def settled(self) -> bool:
        return not self._soon.isActive() and not self._busy

    def why_not_kept(self, entry: RunEntry) -> str:
        if entry.kept:
            return ""
        if entry is self._track.entry:
            return "The run is stored when it is complete."
        if entry.kind == "trial":
            return "A trial is stored when you make it the active run."
        if _from_file(entry):
            return "A run opened from a file is stored with Store run in project."
        return self._project.why_no_edit() or "The run is not stored yet."

    def facts(self, entry: RunEntry) -> project_runs.RunFacts | None:
        if entry.facts is not None:
            return entry.facts
        if entry is self._track.entry:
            return None
        if entry.stored is not None:
            meta = entry.stored.meta
        elif entry.origin is not None:
            meta = {**entry.origin.meta, "wall_seconds": entry.wall_seconds}
        else:
            return None
        tracked = sum(frame.tracked for frame in entry.frames.values())
        return project_runs.run_facts(project_runs.facts_of_meta(meta, entry.numbers(), tracked))

    def keep(self, entry: RunEntry) -> None:
        self._tried.discard(entry)
        self._wanted.add(entry)
        self._soon.start()

    def rename(self, entry: RunEntry, name: str) -> None:
        name = name.strip()
        if not name or name == entry.name:
            return
        if not entry.kept:
            self._runs.rename(entry, name)
            return
        if self._project.apply(project_runs.rename_run(entry.kept, name)) is not None:
            entry.kept = entry.name = name
        self._runs.tell(Part.RUNS)  # where it was refused, the list shows the old name again

    def remove(self, entry: RunEntry) -> None:
        """Take a run from the list; one that the project keeps can be restored."""
        if entry in self._busy:
            return
        if entry.kept:
            if self._project.apply(project_runs.delete_run(entry.kept)) is None:
                return
            self.removed.append(entry.kept)
        self._runs.remove(entry)

    def restore(self) -> None:
        project = self._project.project
        if project is not None and self.removed:
            name = self.removed.pop()
            if self._project.apply(project_runs.restore_run(name)) is not None:
                self._list(project, shown=[name])

    def _look(self) -> None:
        project = self._project.project
        if project is None or self._document.recording is None:
            return
        if project is not self._listed:
            self._listed = project
            self._list(project)
            if not project.read_only and project_runs.unfinished_runs(project.path):
                take, done = partial(_taken_in, project), self._on_taken_in
                title, again = "storing interrupted runs", self._soon.start
                self._tasks.write(Job(title, lambda _task: take(), done, ended=again))
        if not project.read_only:
            busy = any(one.facts is None for one in self._busy)
            for entry in self._to_keep()[: not busy]:  # the next one when this one has its name
                work = partial(_kept, project, entry.name, entry.now())
                done = partial(self._on_kept, project, entry, entry.name)
                self._begin(f"storing run {entry.name}", entry, work, done, writes=True)
        shown = (one for one in self._runs.entries if one.visible or one is self._runs.active)
        for entry in shown:
            if entry.waiting and entry not in self._tried:
                read, found = partial(_read, project, entry.kept), partial(self._on_read, entry)
                self._begin(f"loading run {entry.name}", entry, read, found)
        self._remember_shown(project)

    def _to_keep(self) -> list[RunEntry]:
        def is_due(entry: RunEntry) -> bool:
            wanted = entry in self._wanted or (entry.kind == "run" and not _from_file(entry))
            known = entry.origin is not None or entry.stored is not None
            free = entry not in self._tried and entry not in self._busy
            return wanted and known and free and not entry.kept and not self._track.holds(entry)

        return [entry for entry in self._runs.entries if entry.frames and is_due(entry)]

    def _begin(
        self,
        title: str,
        entry: RunEntry,
        work: Callable[[], object],
        done: Callable[[Any], None],
        *,
        writes: bool = False,
    ) -> None:
        if entry in self._busy:
            return
        self._tried.add(entry)  # what fails is told by the window, and not tried for ever
        job = Job(title, lambda _task: work(), done, ended=partial(self._on_ended, entry))
        self._busy[entry] = self._tasks.write(job) if writes else self._tasks.run(job)

    def _on_kept(
        self, project: Project, entry: RunEntry, asked: str, row: project_runs.KeptRun
    ) -> None:
        if project is not self._project.project:
            return  # closed meanwhile; the next time it is opened it has the run
        wanted = entry.name
        _take_row(entry, row)
        self._tried.discard(entry)
        self._runs.tell(Part.RUNS)
        if wanted != asked:  # a person has renamed it meanwhile
            self.rename(entry, wanted)

    def _on_read(
        self, entry: RunEntry, read: tuple[Run, BodyModel, dict[int, TrackedFrame]]
    ) -> None:
        self._tried.discard(entry)
        if entry not in self._runs.entries:
            return
        entry.stored, entry.body, frames = read
        entry.frames.update(frames)
        entry.wall_seconds = float(entry.stored.meta.get("wall_seconds") or 0.0)
        active = entry is self._runs.active
        self._runs.tell(Part.RUNS | Part.ACTIVE_RUN if active else Part.RUNS)

    def _on_ended(self, entry: RunEntry) -> None:
        del self._busy[entry]
        self._soon.start()

    def _list(self, project: Project, shown: list[str] | None = None) -> None:
        """Put runs of the project that are not in the list into it, and show some of them."""
        kept = self._kept(project)
        if not kept:
            return
        if shown is None:
            stored = project.view_settings.get(_SHOWN)
            shown = stored if isinstance(stored, list) else [kept[-1].name]
        own = {entry.kept for entry in self._runs.entries}
        for one in kept:
            if one.name not in own:
                entry = self._entry_of(one, visible=one.name in shown)
                first = bool(shown) and one.name == shown[0]
                self._runs.add(entry, active=first and self._runs.active is None)

    def _on_taken_in(self, taken: tuple[list[project_runs.TakenIn], list[InputError]]) -> None:
        runs, refusals = taken
        for refusal in refusals:
            self._notifier.error(refusal)
        project = self._project.project
        if runs and project is not None:
            self._list(project, shown=[one.name for one in runs])
            count = "a run" if len(runs) == 1 else f"{len(runs)} runs"
            what = f"the program ended during {count}; the frames tracked so far were stored"
            remedy = "To continue a run, go to its last frame and run the tracker from there."
            self._notifier.show(Message("note", what, ", ".join(one.name for one in runs), remedy))

    def _kept(self, project: Project) -> tuple[project_runs.KeptRun, ...]:
        try:
            self.removed = list(project_runs.removed_runs(project.runs))
            return project_runs.kept_runs(project.runs)
        except InputError as error:
            self._notifier.error(error)
            return ()

    def _entry_of(self, kept: project_runs.KeptRun, *, visible: bool) -> RunEntry:
        facts, recording = kept.facts, self._document.recording
        subject = recording.subject if recording is not None else None
        first, last = facts.first, facts.last
        wanted = range(first, last + 1) if first is not None and last is not None else range(0)
        return RunEntry(
            kept.name, facts.preset, None, body_of_subject(subject), wanted,
            visible=visible, kept=kept.name, facts=facts,
            wall_seconds=facts.wall_seconds or 0.0,
        )  # fmt: skip

    def _remember_shown(self, project: Project) -> None:
        active = self._runs.active
        shown = [active] if active is not None and active.visible else []
        shown += [entry for entry in self._runs.shown_beside() if entry.kept]
        names = [entry.kept for entry in shown if entry.kept]
        if not project.read_only and project.view_settings.get(_SHOWN) != names:
            project.view_settings.set(_SHOWN, names)

    def _keep_what_is_left(self) -> None:
        """Store finished and stopped runs before the project is closed."""
        self._track.stop(at_once=True)
        project = self._project.project
        for task in list(self._busy.values()):
            task.join(10.0)
        if project is None or project.read_only:
            return
        for entry in self._to_keep():
            try:
                _take_row(entry, _kept(project, entry.name, entry.now()))
            except InputError as error:
                self._notifier.error(error)
        self._remember_shown(project)

    def _forget(self) -> None:
        self._listed, self.removed = None, []
        self._tried.clear()


def _take_row(entry: RunEntry, row: project_runs.KeptRun) -> None:
    entry.kept, entry.name, entry.facts = row.name, row.name, row.facts


def _from_file(entry: RunEntry) -> bool:
    """Whether a run was opened from a file; one that was saved to a file is another thing."""
    return entry.path is not None and entry.origin is None


def _kept(project: Project, wanted: str, now: RunEntry) -> project_runs.KeptRun:
    """Put a run into the project; may take a while, in any thread."""
    run = now.run()
    if run is None:
        raise InputError("the source of the run is not known", where=wanted)
    name = project_runs.free_name(project.runs, wanted)
    project.apply(project_runs.keep_run(name, run))
    if now.journal is not None:
        now.journal.unlink(missing_ok=True)
    return next(one for one in project_runs.kept_runs(project.runs) if one.name == name)


def _taken_in(project: Project) -> tuple[list[project_runs.TakenIn], list[InputError]]:
    """Runs that were under way and are kept now, and what stood against keeping others."""
    runs: list[project_runs.TakenIn] = []
    refusals: list[InputError] = []
    for path in project_runs.unfinished_runs(project.path):
        try:
            taken = project_runs.take_in(project, path)
        except InputError as error:
            refusals.append(error)
        else:
            runs += [] if taken is None else [taken]
    return runs, refusals


def _read(project: Project, name: str) -> tuple[Run, BodyModel, dict[int, TrackedFrame]]:
    run = project_runs.load_run(project.runs, name)
    return run, body_of_run(run), frames_of_run(run)
