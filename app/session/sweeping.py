"""Runs made by a process of their own that may go on without the window: sweeps and studies."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Literal, TypeAlias

from PySide6.QtCore import QElapsedTimer, QObject, QSettings, QTimer, Signal, Slot

from stereotrack_core.counting import counted, in_words
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.store import SweepPlaces, SweepState, is_running, read_state
from stereotrack_core.locks import refuse_second
from stereotrack_core.own_program import BOUND, GO_ON, STOP, program_command

from ..services.stored import stored_text

SweepPhase: TypeAlias = Literal["idle", "running", "stopping", "done", "stopped", "failed"]

_LOOK_MS = 300
_LOCK_LOOK_MS = 1500


@dataclass(frozen=True)
class SweepNow:
    """How a sweep stands."""

    phase: SweepPhase = "idle"
    share: float = 0.0
    """0 to 1."""
    words: str = ""
    table: Path | None = None

    @property
    def going(self) -> bool:
        """Whether it is being computed."""
        return self.phase in ("running", "stopping")


class SweepPresenter(QObject):
    """Begins, follows and stops a sweep; finds one again that an earlier window has begun.

    `name`: under which it is remembered which one that was, ``sweep`` or ``study``.
    """

    changed = Signal(object)
    """SweepNow."""

    def __init__(
        self, settings: QSettings, parent: QObject | None = None, name: str = "sweep"
    ) -> None:
        super().__init__(parent)
        self._settings = settings
        self._table, self._goes_on = f"{name}/table", f"{name}/goes_on"
        self.now = SweepNow()
        self._process: subprocess.Popen[bytes] | None = None
        self._said: IO[bytes] | None = None
        self._places: SweepPlaces | None = None
        self._seen = QElapsedTimer()
        self._timer = QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)
        self._find()

    @property
    def goes_on(self) -> bool:
        """Whether a sweep goes on when the window is closed."""
        return bool(self._settings.value(self._goes_on, True, type=bool))

    @goes_on.setter
    def goes_on(self, wanted: bool) -> None:
        self._settings.setValue(self._goes_on, wanted)
        self._say_whether_it_goes_on(wanted)

    @property
    def last_table(self) -> Path | None:
        """Table of the last sweep that was begun here."""
        stored = stored_text(self._settings, self._table)
        return Path(stored) if stored else None

    def begin(self, arguments: Sequence[str], table: Path) -> None:
        """Begin a sweep, or go on with it; one that another process is at is left to it."""
        try:
            refuse_second(table)
        except InputError as error:
            self._tell(SweepNow("failed", 0.0, str(error), table))
            return
        self._places = SweepPlaces(table)
        self._settings.setValue(self._table, str(table))
        self._places.state.unlink(missing_ok=True)
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 - it lives as long as the process
        self._process = subprocess.Popen(  # noqa: S603 - our own code in our own interpreter
            program_command(arguments),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._said,
            start_new_session=True,  # Ctrl-C is for the window
            env={**os.environ, **BOUND, "OPENBLAS_NUM_THREADS": "1"},
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._say_whether_it_goes_on(self.goes_on)
        self._tell(SweepNow("running", 0.0, "Starting the processes.", table))
        self._timer.start()

    def stop(self) -> None:
        """Ask the sweep to stop; what is done is kept."""
        if self._places is not None and self.now.going:
            self._places.stop_sign.touch()
            if self._process is not None:
                self._process.terminate()  # it listens; before it does, there is nothing to lose
                self._say_whether_it_goes_on(True)  # once is enough
            words = "Stopping. Finished runs are kept."
            self._tell(SweepNow("stopping", self.now.share, words, self._places.table))

    def leave(self) -> None:
        """The window is closed: the sweep stops, unless it shall go on."""
        self._timer.stop()
        if self.now.going and not self.goes_on:
            self.stop()
        if self._said is not None:
            self._said.close()
        if self._process is not None:
            self._process.returncode = self._process.returncode or 0  # it is left on purpose
            self._let_go()

    def _say_whether_it_goes_on(self, wanted: bool) -> None:
        """Tell the process what to do when the window is gone, killed, too."""
        if self._process is not None and self._process.stdin is not None:
            with suppress(OSError):  # it has ended
                self._process.stdin.write(GO_ON if wanted else STOP)
                self._process.stdin.flush()

    def _let_go(self) -> None:
        """Close what leads to the process."""
        if self._process is not None and self._process.stdin is not None:
            with suppress(OSError):
                self._process.stdin.close()
        self._process = None

    def _find(self) -> None:
        """Follow a sweep that goes on from before."""
        table = self.last_table
        if table is not None and is_running(SweepPlaces(table)):
            self._places = SweepPlaces(table)
            self._seen.start()
            self._timer.start()
            self._look()

    @Slot()
    def _look(self) -> None:
        places = self._places
        if places is None:
            return
        ended = self._has_ended(places)
        state = read_state(places)
        if ended:
            self._timer.stop()
            self._tell(self._end(places, state))
        elif state is not None and not state.ended and self.now.phase != "stopping":
            self._tell(SweepNow("running", state.share, _going_words(state), places.table))

    def _has_ended(self, places: SweepPlaces) -> bool:
        if self._process is not None:
            return self._process.poll() is not None
        if self._seen.elapsed() < _LOCK_LOOK_MS:
            return False
        self._seen.start()
        return not is_running(places)

    def _end(self, places: SweepPlaces, state: SweepState | None) -> SweepNow:
        said = self._last_words()
        code = self._process.returncode if self._process is not None else None
        self._let_go()
        table = places.table
        if state is None and self.now.phase == "stopping":
            return SweepNow("stopped", 0.0, "Stopped before any run was finished.", table)
        if code == 2 or state is None:
            return SweepNow("failed", 0.0, said or "The sweep could not be started.", table)
        if state.ended == "done":
            return SweepNow("done", 1.0, _done_words(state), table)
        if state.ended == "stopped":
            words = "Stopped. Finished runs are kept; Start resumes the sweep."
            return SweepNow("stopped", state.share, words, table)
        words = state.error or said or "The sweep was ended from outside. Start resumes it."
        return SweepNow("failed", state.share, words, table)

    def _last_words(self) -> str:
        """What the process said last."""
        if self._said is None:
            return ""
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        self._said.close()
        self._said = None
        return lines[-1].removeprefix("stereotrack: ") if lines else ""

    def _tell(self, now: SweepNow) -> None:
        if now != self.now:
            self.now = now
            self.changed.emit(now)


def _going_words(state: SweepState) -> str:
    done = state.reused + state.computed
    said = f"{done} of {counted(state.jobs, 'run')} done"
    if state.failed:
        said += f", {state.failed} failed"
    if state.seconds_left is not None:
        said += f", about {in_words(state.seconds_left)} left"
    return f"{said}."


def _done_words(state: SweepState) -> str:
    said = f"Done: {counted(state.computed, 'run')} computed, {state.reused} reused"
    if state.failed:
        return f"{said}; {state.failed} failed (see the table)."
    return f"{said}."
