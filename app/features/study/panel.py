"""Between a study and the rest of the window: the parameter panel, and folders to add."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QAbstractItemView, QFileDialog, QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import value_text
from stereotrack_core.study.description import Study, StudyRecording, StudySettings
from stereotrack_core.study.points import SPECIAL
from stereotrack_core.tracking.presets import PRESETS, preset

from ...context import Context
from ...session.session import Session
from ...session.tracking import Chosen


def panel_settings(session: Session, settings: StudySettings) -> StudySettings:
    """Settings with the preset and the parameters of the parameter panel."""
    track = session.track
    base = preset(track.preset).values()
    changes = tuple(
        f"{name}={value!r}" if isinstance(value, float) else f"{name}={value_text(value)}"
        for name, value in track.settings.values().items()
        if value != base[name]
    )
    return replace(settings, preset=track.preset, changes=changes)


def study_of_open(context: Context, path: Path) -> Study:
    """A study of the open recording alone, with the parameter panel's settings."""
    session, study = context.session, Study(path)
    recording, project, seen = (
        session.document.recording,
        session.project.path,
        session.keypoints,
    )
    own = "" if project is None else study.relative(project)
    folder = "" if recording is None else study.relative(recording.folder.resolve())
    row = StudyRecording(folder, own, own if seen.wanted and seen.cameras else "")
    settings, stretch = panel_settings(session, StudySettings()), context.view_state.selection
    if stretch:
        settings = replace(settings, frames=f"{stretch.start}:{stretch.stop}")
    return replace(study, rows=(row,), settings=settings)


def apply_to_panel(context: Context, values: Mapping[str, str]) -> None:
    """Put a point's values into the parameter panel."""
    name = values.get("preset", "")
    own = {key: value for key, value in values.items() if key not in SPECIAL and value}
    chosen = context.session.track.chosen
    if name in PRESETS:
        chosen = Chosen(name, preset(name), preset(name))
    elif not own:
        told = ", ".join(f"{one} {value}" for one, value in values.items())
        context.notifier.say(f"The parameter panel has no such parameters: {told}.", 6000)
        return
    try:
        chosen = replace(chosen, settings=chosen.settings.replaced(**own))
    except InputError as error:
        context.notifier.error(error)
        return
    said = ", ".join(f"{one.replace('_', ' ')} {value}" for one, value in own.items()) or name
    context.session.tracker.take(chosen, f"apply {said}")
    context.notifier.say(f"Applied: {said}.", 6000)


def ask_for_folders(
    parent: QWidget, start: Path, use: Callable[[tuple[Path, ...]], object]
) -> None:
    """Let the person choose several folders at once, which dialogs of the system do not offer."""
    dialog = QFileDialog(parent, "Add folders with recordings", str(start))
    dialog.setFileMode(QFileDialog.FileMode.Directory)
    dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
    for view in dialog.findChildren(QAbstractItemView):
        if view.objectName() in ("listView", "treeView"):
            view.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
    dialog.filesSelected.connect(lambda chosen: use(tuple(map(Path, chosen))))
    dialog.open()
