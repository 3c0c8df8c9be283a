"""The frame of dialogs that fill in a form: contents, a line of words, buttons."""

import re
from collections.abc import Callable, Iterable, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any, TypeAlias

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QInputDialog,
    QLabel,
    QLineEdit,
    QMessageBox,
    QPushButton,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.project.exporting import ExportFormat

from ..style.building import Item, label, named, show_text, vbox
from ..style.theme import set_look
from .numbers import NumberField, WholeNumberField, refusal_in


class FormDialog(QDialog):
    """A form that is accepted by one button.

    `run` does what the button says, and closes the dialog; with `close` the other button says Close
    instead of Cancel.
    """

    def __init__(
        self, title: str, accept: str, run: Callable[[], None], parent: QWidget | None = None, *,
        close: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(parent)
        self.setWindowTitle(title)
        self.words = label()
        standard, role = QDialogButtonBox.StandardButton, QDialogButtonBox.ButtonRole
        self.buttons = QDialogButtonBox(standard.Close if close else standard.Cancel)
        self._run = run
        self.accept_button = push_button(accept, self._take_over)
        self.accept_button.setAutoDefault(True)
        self.buttons.addButton(self.accept_button, role.AcceptRole)
        self.buttons.rejected.connect(self.reject)

    def lay_out(self, *items: Item, size: tuple[int, int]) -> None:
        self.setLayout(vbox(*items, self.words, self.buttons, margins=(9, 9, 9, 9)))
        self.resize(*size)

    def _take_over(self) -> None:
        """Do what the button says, unless a field has just refused what was typed."""
        if refusal := refusal_in(self):
            self.say(refusal, error=True)
        else:
            self._run()

    def say(self, text: str, *, error: bool = False) -> None:
        say_in(self.words, text, error=error)

    def attempt(self, do: Callable[[], object]) -> bool:
        try:
            do()
        except InputError as error:
            self.say(str(error), error=True)
            return False
        return True


def ask_for_number(
    parent: QWidget,
    title: str,
    text: str,
    field: NumberField,
    use: Callable[[Any], object],
    about: Callable[[float], str] | None = None,
) -> None:
    """Let the person type a number into a field, which is made for it; says what is `about` it."""

    def take() -> None:
        use(field.value() if isinstance(field, WholeNumberField) else field.stored())
        dialog.accept()

    dialog = FormDialog(title, "OK", take, parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    field.setAccessibleName(title)
    dialog.lay_out(label(text), field, size=(340, 130 if about is None else 190))
    if about is not None:
        field.valueChanged.connect(lambda: dialog.say(about(field.stored())))
        dialog.say(about(field.stored()))
    field.selectAll()
    dialog.open()


def ask_for_text(
    parent: QWidget, title: str, words: str, use: Callable[[str], object], text: str = ""
) -> QInputDialog:
    """Let the person type a line of text."""
    dialog = QInputDialog(parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setWindowTitle(title)
    dialog.setLabelText(words)
    dialog.setTextValue(text)
    dialog.textValueSelected.connect(use)
    dialog.open()
    return dialog


Use: TypeAlias = Callable[[Path], object]
"""What is done with the file or folder that a person chooses; nothing where none is chosen."""


def ask_to_open(parent: QWidget, title: str, start: Path | str, files: str, use: Use) -> None:
    """Let the person choose a file to read; `files` are shown first, all others on request."""
    chosen, _ = QFileDialog.getOpenFileName(parent, title, str(start), f"{files};;All files (*)")
    if chosen:
        use(Path(chosen))


def ask_to_open_several(
    parent: QWidget, title: str, start: Path | str, files: str, use: Callable[[list[Path]], object]
) -> None:
    """Let the person choose files to read together."""
    chosen, _ = QFileDialog.getOpenFileNames(parent, title, str(start), f"{files};;All files (*)")
    if chosen:
        use([Path(one) for one in chosen])


def files_of(words: str, suffixes: Iterable[str]) -> str:
    """Files with these suffixes as dialogs list them: ``Predictions (*.csv *.h5)``."""
    return f"{words} ({' '.join(f'*{suffix}' for suffix in dict.fromkeys(suffixes))})"


def ask_to_save(
    parent: QWidget,
    title: str,
    proposed: Path | str,
    files: str,
    use: Use,
    *,
    goes_on: bool = False,
) -> None:
    """Let the person choose a file to write; one that is there is asked about, or gone on with."""
    options = QFileDialog.Option.DontConfirmOverwrite if goes_on else QFileDialog.Option(0)
    chosen, _ = QFileDialog.getSaveFileName(parent, title, str(proposed), files, options=options)
    if not chosen:
        return
    path, usual = Path(chosen), re.search(r"\*(\.\w+)", files)
    if not path.suffix and usual:
        path = path.with_suffix(usual[1])  # the dialog has asked about the file without it
        question = f"{path.name} exists already. Replace it?"
        yes = QMessageBox.StandardButton.Yes
        if path.exists() and not goes_on and QMessageBox.question(parent, title, question) != yes:
            return
    use(path)


def file_filter(form: ExportFormat) -> str:
    """A format as file dialogs list it: ``C3D (*.c3d)``; says where a library is missing."""
    return files_of(f"{form.label}{', not installed' if form.missing else ''}", form.suffixes)


def ask_to_export(
    parent: QWidget,
    title: str,
    proposed: Path | str,
    formats: Sequence[ExportFormat],
    use: Callable[[Path, ExportFormat], object],
) -> None:
    """Let the person choose a file to write and the format.

    A suffix that is typed decides; that of the proposed name follows the format that is chosen.
    """
    filters, proposed = {file_filter(form): form for form in formats}, Path(proposed)
    dialog = QFileDialog(parent, title, str(proposed.parent))
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setNameFilters(list(filters))
    dialog.selectFile(proposed.name)

    def follow(name: str) -> None:
        path = Path(next(iter(dialog.selectedFiles()), proposed.name))
        suffix = filters[name].suffixes[0]
        dialog.setDefaultSuffix(suffix)
        dialog.selectFile(path.with_suffix(suffix).name)

    def take(chosen: str) -> None:
        path, form = Path(chosen), filters.get(dialog.selectedNameFilter(), formats[0])
        typed = next((one for one in formats if path.suffix.lower() in one.suffixes), None)
        if path.suffix == proposed.suffix and typed is not form:
            path = path.with_suffix("")
        elif typed is not None and path.suffix.lower() not in form.suffixes:
            form = typed
        named = form.named(path)
        names = chain((named,), (named.with_stem(f"{named.stem}-{k}") for k in count(2)))
        if str(named) != chosen:  # which the dialog has asked about, and about no other
            named = next(one for one in names if not one.exists())
        use(named, form)

    dialog.setDefaultSuffix(formats[0].suffixes[0])
    dialog.filterSelected.connect(follow)
    dialog.fileSelected.connect(take)
    dialog.show()


def ask_for_folder(parent: QWidget, title: str, start: Path | str, use: Use) -> None:
    """Let the person choose a folder."""
    chosen = QFileDialog.getExistingDirectory(parent, title, str(start))
    if chosen:
        use(Path(chosen))


def say_in(words: QLabel, text: str, *, error: bool = False) -> None:
    """Say something in a label, as an error or muted; nothing hides it."""
    show_text(words, text)
    set_look(words, "role", "error" if error else "muted")


def push_button(text: str, do: Callable[[], object], tip: str = "") -> QPushButton:
    """A button that Enter in a field of the form does not press."""
    button = named(QPushButton(text, autoDefault=False), tip=tip)
    button.clicked.connect(lambda _checked=False: do())
    return button


def line_edit(name: str, text: str = "", placeholder: str = "", tip: str = "") -> QLineEdit:
    """A line to type in, with what a screen reader calls it."""
    return named(QLineEdit(text, placeholderText=placeholder), name, tip)
