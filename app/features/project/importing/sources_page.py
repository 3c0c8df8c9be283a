"""First step, what each source shows, and last step, the name and the folder of the recording."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QPixmap, QTransform
from PySide6.QtWidgets import (
    QCheckBox,
    QFormLayout,
    QGridLayout,
    QLabel,
    QProgressBar,
    QWidget,
    QWizardPage,
)

from stereotrack_core.arrays import ImageArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import (
    ROLES,
    Choices,
    Role,
    Source,
    Use,
    doubts_about,
    problems_of,
    view_for,
)
from stereotrack_core.recording.importing.files import files_of
from stereotrack_core.recording.importing.making import calibration_notes, check_place
from stereotrack_core.recording.importing.proposing import possible_units, propose
from stereotrack_core.recording.importing.readers import first_picture
from stereotrack_core.recording.importing.sources import Found, look_at

from ....widgets.camera.picture import image_of
from ....widgets.forms.form_dialog import ask_for_folder, line_edit, push_button, say_in
from ....widgets.style.building import (
    choice,
    hbox,
    holder,
    label,
    label_of,
    named,
    scrolled,
    show_text,
    vbox,
)

_WIDTH, _HEIGHT = 120, 90
_WORDS = (
    "Say what each source shows. The left and the right image of a stereo camera get the same "
    "view name, as do a depth map and its image."
)
_HEADINGS = ("First image", "Source", "Shows", "View", "Mirrored")
_MIRRORED = (
    "The images are mirror images, as those of the Kinect v1. They are turned back, which writes "
    "them again."
)
_MOST_PROBLEMS = 3


@dataclass(frozen=True, eq=False)
class Looked:
    """Sources with their first pictures, and what is proposed to be made of them."""

    found: Found
    proposed: Choices
    pictures: Mapping[str, ImageArray]
    """First picture by the source's name; absent where it cannot be decoded."""
    problems: tuple[InputError, ...]
    middle_m: float
    """Metres to the middle of the depth scene for each metre of a count; NaN without depth."""
    place: Path  # where the recording goes unless the person chooses another folder


def look(paths: Sequence[Path]) -> Looked:
    """Look at what was named, read the first pictures, and propose.

    Raises InputError where nothing usable was found.
    """
    found = look_at(paths)
    proposed = propose(found)
    pictures, problems = {}, list(found.problems)
    for use in proposed.uses:
        source = use.source
        try:
            pictures[source.name] = first_picture(source, as_depth=use.role == "depth")
        except InputError as problem:
            problems.append(problem)
    depths = [source for source in found.sources if source.kind == "depth"]
    middle = math.nan
    if depths:
        unit, metres = possible_units(depths[0])[0]
        middle = metres / unit
        proposed = replace(proposed, depth_unit=depths[0].unit or unit)
    return Looked(found, proposed, pictures, tuple(problems), middle, _place(paths, found))


def _place(paths: Sequence[Path], found: Found) -> Path:
    """The folder that was named itself; else a new one beside the files."""
    if found.folder is not None and paths[0].is_dir():
        return found.folder
    parent = found.folder or Path(paths[0]).absolute().parent
    return parent / f"{parent.name or 'videos'}-recording"


def _thumbnail(source: Source, picture: ImageArray | None) -> QPixmap:
    """A small upright picture; a grey one where there is none."""
    if picture is None:
        empty = QPixmap(_WIDTH, _HEIGHT)
        empty.fill(Qt.GlobalColor.darkGray)
        return empty
    turned = image_of(picture).transformed(QTransform().rotate(source.turned))
    kept, smooth = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
    return QPixmap.fromImage(turned.scaled(_WIDTH, _HEIGHT, kept, smooth).copy())


class _Row:
    """The fields of one source."""

    def __init__(self, use: Use) -> None:
        self.use = use
        name = use.source.name
        self.role = choice(f"What {name} shows", ROLES.items(), "What this source shows")
        self.role.setCurrentIndex(self.role.findData(use.role))
        self.view = line_edit(
            f"View of {name}", use.view, tip="Name of the view, such as N or left"
        )
        self.view.setMinimumWidth(90)
        self.mirrored = named(QCheckBox(), f"{name} is mirrored", _MIRRORED)
        self.mirrored.setChecked(use.mirrored)
        self.role.currentIndexChanged.connect(self._propose_view)

    def _propose_view(self) -> None:
        """A view of its own for a source that makes one alone, unless a name was typed."""
        if not self.view.isModified():
            self.view.setText(view_for(self.use, self.role.currentData()))

    def chosen(self) -> Use:
        role: Role = self.role.currentData()
        view = self.view.text().strip()
        return replace(self.use, role=role, view=view, mirrored=self.mirrored.isChecked())


class SourcesPage(QWizardPage):
    """A row for each source: its first picture, and what it is used as."""

    def __init__(self, looked: Looked) -> None:
        super().__init__()
        self.setTitle("Sources")
        self._proposed = looked.proposed
        self.rows = [_Row(use) for use in looked.proposed.uses]
        self.words = label()
        self.words.setObjectName("import_problems")
        self.notes, self._unread = label("", "muted"), label("", "error")
        area = scrolled(self._grid(looked), "Sources")
        told = (self.notes, self._unread, self.words)
        self.setLayout(vbox(label(_WORDS, "muted"), (area, 1), *told))
        unread = [f"Not used: {problem}" for problem in looked.problems[:_MOST_PROBLEMS]]
        show_text(self._unread, "\n".join(unread))
        notes = [f"{note[0].upper()}{note[1:]}." for note in looked.found.notes]
        show_text(self.notes, "\n".join(notes))
        for row in self.rows:
            row.role.currentIndexChanged.connect(self._on_changed)
            row.view.textChanged.connect(self._on_changed)
            row.mirrored.toggled.connect(self._on_changed)
        self._on_changed()

    def _grid(self, looked: Looked) -> QWidget:
        grid = QGridLayout()
        grid.setHorizontalSpacing(14)
        for column, heading in enumerate(_HEADINGS):
            grid.addWidget(label(heading, "muted", wraps=False), 0, column)
        for number, row in enumerate(self.rows, start=1):
            source = row.use.source
            picture = named(QLabel(), f"First image of {source.name}")
            picture.setPixmap(_thumbnail(source, looked.pictures.get(source.name)))
            empty = row.use.background
            more = "" if empty is None else f"\nBackground: {empty.name}"
            about = label(f"{source.name}\n{source.says()}{more}")
            about.setToolTip(str(source.path))
            for column, field in enumerate((picture, about, row.role, row.view, row.mirrored)):
                grid.addWidget(field, number, column)
            grid.setAlignment(row.mirrored, Qt.AlignmentFlag.AlignHCenter)
        grid.setColumnStretch(1, 1)
        grid.setRowStretch(len(self.rows) + 1, 1)
        return holder(grid)

    def chosen(self, choices: Choices) -> Choices:
        return replace(choices, uses=tuple(row.chosen() for row in self.rows))

    def isComplete(self) -> bool:
        return not self._problems()

    def _problems(self) -> list[str]:
        """Problems that prevent making a recording, without the frame rate."""
        choices = self.chosen(replace(self._proposed, fps=self._proposed.fps or 1.0))
        return [str(problem) for problem in problems_of(choices)]

    def _on_changed(self) -> None:
        for row in self.rows:
            used = row.role.currentData() != "unused"
            row.view.setEnabled(used)
            row.mirrored.setEnabled(used)
        problems = self._problems()
        say_in(self.words, "\n".join(problems[:_MOST_PROBLEMS]), error=True)
        self.completeChanged.emit()


class PlacePage(QWizardPage):
    """Name, folder, what will be written, and the progress of that."""

    def __init__(self, looked: Looked) -> None:
        super().__init__()
        self.setTitle("Folder")
        self._choices = looked.proposed
        self.name = line_edit("Name", looked.proposed.name, tip="Name of the recording")
        self.folder = line_edit("Folder", str(looked.place), tip="Folder of the recording")
        browse = push_button("&Choose …", self._ask, "Choose another folder")
        self.summary = label("", "muted")
        self.words = label()
        self.progress = named(QProgressBar(), "Progress")
        self.progress.hide()
        form = QFormLayout()
        form.addRow("&Name", self.name)
        form.addRow(label_of(self.folder, "&Folder"), hbox((self.folder, 1), browse))
        self.setLayout(vbox(form, self.summary, self.progress, self.words, None))
        for field in (self.name, self.folder):
            field.textChanged.connect(self._on_changed)

    def begin(self, choices: Choices) -> None:
        self._choices = choices
        self._on_changed()

    def place(self) -> Path:
        return Path(self.folder.text().strip()).expanduser()

    def chosen(self, choices: Choices) -> Choices:
        return replace(choices, name=self.name.text().strip())

    def isComplete(self) -> bool:
        return not self._problem()

    def _problem(self) -> str:
        if not self.name.text().strip() or not self.folder.text().strip():
            return "Enter a name and a folder."
        try:
            check_place(self._choices, self.place())
        except (InputError, OSError) as error:
            return str(error)
        return ""

    def _ask(self) -> None:
        title, start = "Folder of the recording", self.place().parent
        ask_for_folder(self, title, start, lambda path: self.folder.setText(str(path)))

    def _on_changed(self) -> None:
        problem = self._problem()
        say_in(self.words, problem, error=True)
        self.summary.setText("" if problem else self._what_is_written())
        self.completeChanged.emit()

    def _what_is_written(self) -> str:
        files = files_of(self._choices.used(), self.place())
        stay = sum(one.how == "stay" for one in files)
        copied = {path for one in files if one.how == "copy"
                  for path in (one.use.source.images or (one.use.source.path,))}  # fmt: skip
        converted = [one for one in files if one.how == "convert"]
        views = len({use.view for use in self._choices.used()})
        parts = [f"The recording has {counted(views, 'view')}."]
        if stay:
            parts.append(f"{counted(stay, 'source')} stay where they are.")
        if copied:
            size = sum(path.stat().st_size for path in copied) / 1e6
            parts.append(f"{counted(len(copied), 'file')} will be copied ({size:.0f} MB).")
        if converted:
            names = ", ".join(one.frames for one in converted)
            parts.append(f"Written again: {names}.")
        parts += [f"{one[0].upper()}{one[1:]}." for one in calibration_notes(self._choices)]
        parts += doubts_about(self._choices)
        return " ".join(parts)
