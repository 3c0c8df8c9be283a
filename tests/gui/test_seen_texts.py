"""No text in the window is cut off, and something says what each control does."""

import pytest
from PySide6.QtWidgets import QApplication

from app.shell.dialogs import CommandPalette
from tests.gui.seen_texts import faults_of

pytestmark = pytest.mark.window


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
