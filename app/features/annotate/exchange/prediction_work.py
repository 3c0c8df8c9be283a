"""Predictions of 2-D detectors come into the project and go from it; both are edits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, Qt, Slot
from PySide6.QtWidgets import QInputDialog

from stereotrack_core.counting import counted
from stereotrack_core.project.detectors import DetectorImport
from stereotrack_core.project.project import Project

from ....context import Context
from ....services.actions import Command, Menu
from ..panels import AnnotationPanels
from .predictions import PredictionsDialog


class PredictionExchange(QObject):
    """Asks which files, or which detector."""

    def __init__(
        self, context: Context, panels: AnnotationPanels, export: Callable[[], None]
    ) -> None:
        super().__init__(panels)
        self._context, self._panels, self._export = context, panels, export
        self._keypoints = context.session.keypoints
        self._keypoints.changed.connect(panels.read_kept)
        self._keypoints.changed.connect(panels.repeat_changed)
        panels.leaving.connect(self._close)
        context.tasks.watch(self._settled)

    def commands(self) -> list[Command]:
        """Commands of the menu File."""
        panels = self._panels
        command = Menu("&File", panels.no_edit).command
        return [
            command("annotate-import-predictions", "Import predictions …", "Import the keypoints "
                    "of a 2-D detector. What is taken and what is left out is shown before "
                    "anything is written.", self.ask_to_import, icon="prediction"),
            command("annotate-export-predictions", "Export predictions …", "Write the keypoints "
                    "of all detectors as a table or as COCO results.", self._export,
                    icon="export", why_not=self.why_none),
            command("annotate-remove-predictions", "Remove predictions …", "Remove the keypoints "
                    "and proposals of a detector. You can undo this.", self.ask_to_remove,
                    icon="delete", why_not=self.why_none),
        ]  # fmt: skip

    def why_none(self) -> str:
        """Why nothing can be removed or exported, as a sentence."""
        none = "The project has no predictions of a detector."
        return self._panels.no_edit() or ("" if self._keypoints.sources else none)

    def ask_to_import(self) -> None:
        """Let the person choose files, and show what they contain."""
        panels = self._panels
        if panels.project is None or panels.recording is None:
            return
        dialog = PredictionsDialog(
            panels.project, panels.recording, panels.frame_count or None, panels.window
        )
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.import_requested.connect(self._on_requested)
        self._keypoints.changed.connect(dialog.read_again)
        dialog.show()

    @Slot(object, object)
    def _on_requested(self, project: Project, plan: DetectorImport) -> None:
        kept = counted(len(plan.keypoints), "keypoint")
        said = f"{kept} of {', '.join(plan.after.sources)} imported."
        self._keypoints.bring(project, plan, partial(self._panels.said.emit, said))

    def ask_to_remove(self) -> None:
        """Let the person choose a detector."""
        known = {
            f"{name} ({counted(count, 'keypoint')})": name
            for name, count in self._keypoints.sources.items()
        }
        dialog = QInputDialog(self._panels.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setWindowTitle("Remove predictions")
        dialog.setLabelText("Detector whose keypoints and proposals are removed:")
        dialog.setComboBoxItems(list(known))
        dialog.setOkButtonText("Remove")
        dialog.textValueSelected.connect(lambda words: self.remove(known[words]))
        dialog.open()

    def remove(self, detector: str) -> None:
        """Remove what a detector has predicted."""
        said = f"Predictions of {detector} removed. Undo brings them back."
        self._keypoints.remove(detector, partial(self._panels.said.emit, said))

    def _settled(self) -> bool:
        return all(one.settled() for one in self._panels.window.findChildren(PredictionsDialog))

    @Slot()
    def _close(self) -> None:
        for dialog in self._panels.window.findChildren(PredictionsDialog):
            dialog.close()
