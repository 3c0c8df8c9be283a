"""Questions that presets need answered."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QDialog, QDialogButtonBox, QFormLayout, QLabel, QLineEdit, QWidget


class NameDialog(QDialog):
    """Asks for the name of a preset, and says at once what is wrong with it.

    Parameters
    ----------
    title, what : str
        Title, and what is going to be named.
    name : str
        What is proposed.
    problem_with : callable
        From a name to a sentence that says why it will not do; empty where it will.
    taken : sequence of str
        Names that would be replaced.
    """

    def __init__(
        self,
        title: str,
        what: str,
        name: str,
        problem_with: Callable[[str], str],
        taken: tuple[str, ...],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self._problem_with, self._taken = problem_with, taken
        self.name = QLineEdit(name)
        self.name.setAccessibleName("Name")
        self.name.selectAll()
        self.remark = QLabel()
        self.remark.setWordWrap(True)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        words = QLabel(what)
        words.setWordWrap(True)
        words.setMinimumWidth(320)
        layout = QFormLayout(self)
        layout.addRow(words)
        layout.addRow("Name", self.name)
        layout.addRow(self.remark)
        layout.addRow(self.buttons)
        self.name.textChanged.connect(self._look)
        self._look()

    def _look(self) -> None:
        name = self.name.text()
        problem = self._problem_with(name)
        replaced = name.strip() in self._taken
        self.remark.setText(problem or ("The preset of that name is replaced." * replaced))
        self.buttons.button(QDialogButtonBox.StandardButton.Save).setEnabled(not problem)
