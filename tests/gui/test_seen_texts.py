"""No text in the window is cut off, and something says what each control does."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QLineEdit, QPushButton, QWidget

from app.shell.command_lists import CommandPalette
from tests.gui.seen_texts import faults_of

pytestmark = pytest.mark.window


def test_what_is_wrong_is_found(shown):
    page = QWidget()
    label, button = QLabel("Much too long for it", page), QPushButton("Save", page)
    label.setGeometry(0, 0, 20, 30)
    button.setGeometry(0, 40, 90, 30)
    field = QLineEdit(page)
    field.setGeometry(0, 80, 90, 30)
    field.setToolTip("What it is called")
    box = QComboBox(page)
    box.addItem("A choice that nobody can read")
    box.setGeometry(0, 120, 60, 30)
    box.setAccessibleName("Kind")
    shown(page)
    found = "\n".join(faults_of(page))
    assert "'Much too long for it' needs" in found
    assert "QLineEdit 'What it is called' has no name" in found
    assert "'A choice that nobody can read' needs" in found
    assert "Save" not in found, "in a dialog the words of a button say what it does"


def test_every_workspace_is_readable(opened):
    docks = opened.context.docks
    for space in docks.workspaces:
        docks.show_named(space.name)
        QApplication.processEvents()
        assert faults_of(opened) == [], space.name
    palette = CommandPalette(opened.context.actions, opened)
    palette.show()
    QApplication.processEvents()
    assert faults_of(palette) == []
    palette.close()
    palette.deleteLater()


def test_the_welcome_page_is_readable(window):
    assert faults_of(window) == []
