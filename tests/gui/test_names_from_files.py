"""What files hold is shown as it is written: never as formatting, never as a command."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QLabel, QToolTip, QWidget

from app.session.messages import Message
from app.widgets.forms.message import MessageBar

NAME = "<img src='x'><b>N</b>"


@pytest.fixture
def parent(shown) -> QWidget:
    return shown(QWidget())


def test_labels_show_plain_text_unless_they_say_so(parent, qtbot):
    label, rich, message = QLabel(NAME, parent), QLabel(parent), MessageBar()
    message.setParent(parent)
    rich.setTextFormat(Qt.TextFormat.RichText)
    label.setProperty("role", "muted")
    message.show_message(Message("error", f"there is no view {NAME}"))
    labels = [label, rich, *message.findChildren(QLabel)]
    for each in labels:
        each.show()
    assert {each.textFormat() for each in labels if each is not rich} == {Qt.TextFormat.PlainText}
    assert rich.textFormat() == Qt.TextFormat.RichText


def test_tooltips_show_plain_text(parent, qapp):
    QToolTip.showText(QPoint(5, 5), NAME, parent)
    tips = [each for each in qapp.topLevelWidgets() if each.metaObject().className() == "QTipLabel"]
    assert [(tip.text(), tip.textFormat()) for tip in tips] == [(NAME, Qt.TextFormat.PlainText)]
    QToolTip.hideText()


def test_control_characters_are_spelled_out_in_messages():
    message = Message(
        "error", "the view 'N\x1b[31m\u202e' is not there", "a\x9b.toml", "Name\x07 it."
    )
    sentence = message.sentence()
    assert sentence.isprintable()
    assert "\\u001b[31m\\u202e" in sentence
