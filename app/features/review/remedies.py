"""Why failures begin and what repairs them: commands, and the table of gain against harm."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QWidget

from stereotrack_core.atomic import write_file
from stereotrack_core.evaluation.failure_segments.segment import FAILURE_COLUMNS, failure_rows
from stereotrack_core.tables import csv_text

from ...context import Context
from ...services.actions import Command, Menu
from ...session.changes import Part
from ...session.remedies import HARMLESS, WORTH, Remedy, Tried, is_harmless
from ...session.session import Snapshot, unless
from ...widgets.forms.form_dialog import ask_to_save
from ...widgets.style.building import empty_label, hbox, label, offer, shortened, show_text, vbox
from ...widgets.tables.table import RIGHT, STRETCH, Cell, CellTable, Column

_NOTHING = (
    "Select a failure and choose Find what fixes this: the parameters that its cause points to are "
    "tried up and down on its frames, and the best three on stretches that were good, of this "
    "recording and of the others of an open study. Try without each part tracks it without one "
    "view, term or prior."
)
_HARM = (
    "Most by which one of up to three stretches that were good gets worse, or one arm in the "
    "failure itself. The best three changes are checked; empty: not checked."
)
_IN_STUDY = (
    "Most by which a stretch that was good in another recording of the study gets worse, and in "
    "which one: in degrees if that has a reference, else in failure probability."
)


def _columns(tried: Tried | None) -> tuple[Column, ...]:
    unit = "°" if tried is None else tried.unit.strip()
    gain = (
        f"By how much the arms get better over the failure than with no change, {unit}. All begin "
        "with the run's frame before; of no change, how much better it is than the run"
    )
    columns = (
        Column("Change", "Double-click or press Enter to see it beside the run", width=STRETCH),
        Column("Arms", f"Mean over frames and limbs of both arms, {unit}", RIGHT, width=52),
        Column("Gain", gain, RIGHT, width=52),
        Column("Harm", _HARM, RIGHT, width=52),
    )
    in_study = (
        Column("In study", _IN_STUDY, RIGHT, width=60),
        Column("Worst in", _IN_STUDY, width=130),
    )
    return columns + in_study if tried is not None and tried.others else columns


def remedy_cells(remedy: Remedy) -> Sequence[Cell]:
    """Cells of one change that was tried."""
    change, gain, harm = remedy.change.words, remedy.gain, remedy.harm
    good = "good" if gain >= WORTH else "warning" if gain <= -WORTH else ""
    bad = "" if harm is None else "good" if harm < HARMLESS else "warning"
    shown = "" if harm is None else f"{max(harm, 0.0):.1f}"
    return (
        Cell(change, f"{change}. Double-click to see it.", bold=is_harmless(remedy)),
        Cell(f"{remedy.error:.1f}", value=remedy.error),
        Cell(f"{gain:+z.1f}", colour=good, value=gain),
        Cell(shown, _HARM, bad, value=-1.0 if harm is None else harm),
        *_in_study(remedy),
    )


def _in_study(remedy: Remedy) -> tuple[Cell, Cell]:
    """The largest harm in another recording of the study, and in which one."""
    worst = remedy.worst_elsewhere
    if worst is None:
        return Cell("", _IN_STUDY, value=-1.0), Cell("", _IN_STUDY)
    said = {one.recording: f"{max(one.worst, 0.0):.1f}{one.unit}" for one in remedy.elsewhere}
    tip = "\n".join((_IN_STUDY, *(f"{name}: {harm}" for name, harm in said.items())))
    colour = "good" if worst.worst < HARMLESS else "warning"
    number = Cell(said[worst.recording], tip, colour, value=worst.worst)
    return number, Cell(shortened(Path(worst.recording).name, 18), tip, "muted")


class RemediesPanel(QWidget):
    """Words and progress above, a row per change that was tried, buttons below.

    `activated` is called with the row that a person double-clicks, or presses Enter on, `chosen`
    when another row is selected.
    """

    def __init__(self, activated: Callable[[int], object], chosen: Callable[[], object]) -> None:
        super().__init__()
        self.words = label("", margins=(8, 6, 8, 2))
        self.table = CellTable("Remedies", _columns(None), remedy_cells, least=150, single=True)
        self.table.activated.connect(lambda index: activated(index.row()))
        self.table.selectionModel().currentRowChanged.connect(lambda *_: chosen())
        self._nothing = empty_label(_NOTHING)
        self.buttons = hbox(margins=(6, 0, 6, 0))
        parts = (self.words, (self._nothing, 1), (self.table, 1), self.buttons)
        self.setLayout(vbox(*parts, margins=(0, 0, 0, 4), spacing=2))
        self.show_tried(None, "")

    def show_tried(self, tried: Tried | None, words: str) -> None:
        """Show what was tried so far; the selected row stays the same change."""
        show_text(self.words, words)
        left_out = () if tried is None else tried.left_out
        self.words.setToolTip("\n".join(f"{name}: {error}" for name, error in left_out))
        self._nothing.setVisible(tried is None)
        self.table.setVisible(tried is not None)
        old, row = self.table.cells.rows, self.table.currentIndex().row()
        chosen = old[row].change if 0 <= row < len(old) else None
        remedies = () if tried is None else tried.remedies
        self.table.show_rows(remedies, _columns(tried))
        place = next((k for k, one in enumerate(remedies) if one.change == chosen), -1)
        self.table.setCurrentIndex(self.table.cells.index(place, 0))


class RemedyController:
    """Shows what was tried, and does what a person wants with it."""

    def __init__(self, context: Context) -> None:
        self._context, self._state = context, context.session.remedies
        self._failures = context.session.failures
        self.panel = RemediesPanel(self._show_row, context.actions.refresh_soon)
        context.docks.add("remedies", "Remedies", self.panel)
        context.show(Part.REMEDIES | Part.TASKS, self._show, "remedies")
        context.actions.add(self._commands())
        names = "find_remedy", "find_parts", "stop_remedy", "use_remedy"
        offer(self.panel.buttons, map(context.actions.action, names))

    def _show(self, _now: Snapshot) -> None:
        self.panel.show_tried(self._state.tried, self._state.words())
        self._context.actions.refresh_soon()

    def _chosen(self) -> Remedy | None:
        tried, row = self._state.tried, self.panel.table.currentIndex().row()
        there = tried is not None and 0 <= row < len(tried.remedies)
        return tried.remedies[row] if tried is not None and there else None

    def _show_row(self, _row: int) -> None:
        if (remedy := self._chosen()) is not None:
            self._state.show(remedy)

    def _find(self, kind: str) -> None:
        self._context.docks.bring_up("remedies")
        self._state.find("parts" if kind == "parts" else "remedy")

    def _use(self) -> None:
        if (remedy := self._chosen()) is not None:
            self._state.use(remedy)
            said = f"The next run uses {remedy.change.words}."
            self._context.notifier.say(said, 6000)

    def _inspect(self) -> None:
        failure = self._failures.at_hand()
        if failure is not None:
            self._failures.begin_of(failure)
            if not self._context.session.inspection.on:
                self._context.actions.action("look_inside").trigger()

    def ask_where(self) -> None:
        """Ask where to save the listed failures as a table."""
        recording = self._context.session.document.recording
        name = "failures.csv" if recording is None else f"{recording.folder.name}-failures.csv"
        parent = self._context.docks.dialog_parent
        ask_to_save(parent, "Export failures", name, "Table (*.csv)", self.export)

    def export(self, path: Path) -> None:
        """Write the listed failures as CSV."""
        recording = self._context.session.document.recording
        if recording is not None:
            rows = failure_rows(self._failures.listed, recording.fps)
            text = csv_text([one.removeprefix(">") for one in FAILURE_COLUMNS], rows)
            if self._context.notifier.attempt(lambda: write_file(path, text)):
                self._context.notifier.say(f"Failures saved to {path}.", 6000)

    def _commands(self) -> list[Command]:
        state, failures, session = self._state, self._failures, self._context.session

        def busy() -> str:
            running = "The tracker is running, or changes are tried already. Wait or stop them."
            works = session.tracker_works() or state.running
            return failures.none_listed() or state.why_not() or (running if works else "")

        def no_remedy() -> str:
            remedy = self._chosen()
            if remedy is not None and remedy.change.views is not None:
                return "This change leaves out a view; no setting differs."
            return unless(remedy, "Select a change that was tried, in the panel Remedies.")

        command = Menu("&Review", busy).command
        return [
            command("find_reasons", "Find out why failures begin", "Do the step in which each "
                    "failure begins again, and compare the cost of the true arms with that of "
                    "the chosen ones.", failures.find_reasons, "", "search", section=True,
                    why_not=lambda: failures.why_no_reasons() or session.tracker_works()),
            command("inspect_failure", "Inspect first step of failure", "Go to the frame in which "
                    "the selected failure begins, and inspect the tracker's step there.",
                    self._inspect, why_not=failures.none_listed),
            command("find_remedy", "Find what fixes this", "Try the parameters that the failure's "
                    "cause points to on its frames, and the best three on stretches that were "
                    "good, also in the other recordings of an open study.",
                    partial(self._find, "remedy"), "Shift+F9", "iterate", section=True),
            command("find_parts", "Try without each part", "Track the failure without one view, "
                    "one term or one prior at a time.", partial(self._find, "parts")),
            command("stop_remedy", "Stop trying", "Try no more changes; what was tried stays.",
                    state.stop, why_not=lambda: unless(state.running, "Nothing is tried now.")),
            command("use_remedy", "Use change", "Use the settings of the selected change from now "
                    "on.", self._use, "", "settings", why_not=no_remedy),
            command("export_failures", "Export failures …", "Save the listed failures as a table.",
                    self.ask_where, "", "export", section=True, why_not=failures.none_listed),
        ]  # fmt: skip
