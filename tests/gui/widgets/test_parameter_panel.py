from dataclasses import dataclass

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QLabel

from app.widgets.forms.parameter_panel import ParameterPanel
from stereotrack_core.parameters import ParameterGroup, parameter
from stereotrack_core.tracking.presets import PRESETS, preset

LEFT = Qt.MouseButton.LeftButton


@dataclass(frozen=True)
class Example(ParameterGroup):
    window: int = parameter(11, "Stereo", (5, 51), unit="px", thesis=7)("Side of the window.")
    reach: float = parameter(0.25, "Tracking", unit="m")("Farther data are left out.")
    edges: bool = parameter(True, "Stereo", thesis=False)("Match derivatives.")
    mode: str = parameter("fast", "Tracking", choices=("fast", "slow_one"))("How.")


@pytest.fixture
def panel(shown):
    widget = ParameterPanel()
    widget.set_seen(True)
    widget.set_settings(Example(), Example())
    return shown(widget, 340, 500)


def typed(qtbot, panel, name, text):
    field = panel.line(name).editor
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, text)
    qtbot.keyClick(field, Qt.Key.Key_Return)


def words(widget):
    return " ".join(label.text() for label in widget.findChildren(QLabel) if label.isVisible())


class TestContent:
    def test_line_says_unit_range_default_and_thesis(self, panel):
        text = words(panel.line("window"))
        for part in ("window", "px", "from 5 to 51 px", "default 11", "thesis 7"):
            assert part in text
        assert "Side of the window." in text, "without hovering"

    def test_search_finds_a_name_and_the_line_explains_itself(self, qtbot, shown):
        widget = ParameterPanel()
        widget.set_settings(preset("fast"), preset("fast"))
        widget.set_seen(True)
        shown(widget, 340, 500)
        qtbot.keyClicks(widget.search, "arms apart")
        assert widget.line("arms_apart").isVisible()
        assert not widget.line("matcher").isVisible()
        line = widget.line("arms_apart")
        assert line.row.help[:30] in words(line), "its beginning, without hovering"
        QApplication.processEvents()  # what the search has hidden gives its place away
        before = line.editor.mapToGlobal(QPoint(0, 0))
        qtbot.mouseClick(line.editor, Qt.MouseButton.LeftButton)
        assert line.row.help in words(line), "all of it, where a person goes to it"
        moved = line.editor.mapToGlobal(QPoint(0, 0)) - before
        assert moved.manhattanLength() <= 2, "the field stays under the mouse"

    def test_every_parameter_of_the_program_has_a_line(self, shown):
        widget = ParameterPanel()
        widget.set_settings(preset("thesis"), preset("thesis"))
        shown(widget, 340, 500)
        for row in preset("thesis").rows():
            assert (
                widget.line(row.name).editor.accessibleName().startswith(row.name.replace("_", " "))
            )


def follow_link(_qtbot, panel):
    labels = panel.line("window").findChildren(QLabel)
    next(label for label in labels if "href" in label.text()).linkActivated.emit("thesis")


GIVEN = {
    "number": (lambda qtbot, panel: typed(qtbot, panel, "window", "21"), Example(window=21)),
    "switch": (lambda _qtbot, panel: panel.line("edges").editor.click(), Example(edges=False)),
    "choice": (
        lambda qtbot, panel: qtbot.keyClick(panel.line("mode").editor, Qt.Key.Key_Down),
        Example(mode="slow_one"),
    ),
    "thesis": (follow_link, Example(window=7)),
}


class TestEditing:
    @pytest.mark.parametrize(("give", "settings"), GIVEN.values(), ids=GIVEN)
    def test_what_is_given_is_told_and_shown(self, qtbot, panel, give, settings):
        with qtbot.waitSignal(panel.settings_changed) as caught:
            give(qtbot, panel)
        assert caught.args == [settings]
        assert panel.settings == settings

    @pytest.mark.parametrize(
        ("text", "sentence"),
        [
            ("400", "'400' is not a valid value. Give a value from 5 to 51 px."),
            ("many", "'many' is not a valid value. Give a whole number."),
            ("", "'' is not a valid value. Give a whole number."),
        ],
    )
    def test_refused_with_the_rows_sentence(self, qtbot, panel, text, sentence):
        with qtbot.assertNotEmitted(panel.settings_changed):
            typed(qtbot, panel, "window", text or " ")
        assert panel.line("window").refusal == sentence
        assert panel.line("window").editor.text().strip() == text
        assert panel.settings == Example()

    def test_escape_takes_a_refused_text_back(self, qtbot, panel):
        typed(qtbot, panel, "window", "400")
        qtbot.keyClick(panel.line("window").editor, Qt.Key.Key_Escape)
        assert panel.line("window").editor.text() == "11"
        assert panel.line("window").refusal == ""


class TestRevert:
    def test_changed_is_marked_and_goes_back(self, qtbot, panel):
        line = panel.line("window")
        assert not line.revert_button.isVisible()
        typed(qtbot, panel, "window", "21")
        assert "●" in words(line)
        with qtbot.waitSignal(panel.settings_changed) as caught:
            qtbot.mouseClick(line.revert_button, LEFT)
        assert caught.args == [Example()]
        assert "●" not in words(line)

    def test_it_goes_back_to_the_preset_not_to_the_default(self, qtbot, panel):
        panel.set_settings(Example(window=9), Example(window=15))
        qtbot.mouseClick(panel.line("window").revert_button, LEFT)
        assert panel.settings == Example(window=15)
        assert "preset 15" in words(panel.line("window"))

    def test_all_at_once(self, qtbot, panel):
        panel.set_settings(Example(window=9, edges=False), Example())
        with qtbot.waitSignal(panel.settings_changed) as caught:
            qtbot.mouseClick(panel.revert_all, LEFT)
        assert caught.args == [Example()]
        assert not panel.revert_all.isEnabled()


class TestSifting:
    def visible(self, panel):
        return {r.name for r in Example.rows() if panel.line(r.name).isVisible()}

    def test_search_looks_into_names_and_explanations(self, qtbot, panel):
        qtbot.keyClicks(panel.search, "derivatives")
        assert self.visible(panel) == {"edges"}
        qtbot.keyClick(panel.search, Qt.Key.Key_Return)
        assert panel.focusWidget() is panel.line("edges").editor
        panel.search.clear()
        qtbot.keyClicks(panel.search, "tracking data")
        assert self.visible(panel) == {"reach"}
        assert "Stereo" not in words(panel)

    def test_what_differs_is_pinned_to_the_top_and_goes_back(self, qtbot, panel):
        def order():
            lines = [panel.line(row.name) for row in Example.rows()]
            return [one.row.name for one in sorted(lines, key=lambda line: line.y())]

        assert order()[0] == "window"
        panel.line("mode").editor.setFocus()
        qtbot.keyClick(panel.line("mode").editor, Qt.Key.Key_Down)
        assert order() == ["mode", "window", "edges", "reach"]
        assert panel.changed_words.text() == "1 changed from the preset"
        assert panel.line("mode").editor.hasFocus(), "whoever changes it again need not look for it"
        qtbot.mouseClick(panel.line("mode").revert_button, LEFT)
        qtbot.waitUntil(lambda: order() == ["window", "edges", "reach", "mode"])  # by group
        assert not panel.changed_words.isVisible()


class TestPresets:
    def test_choice_is_asked_for(self, qtbot, panel):
        panel.set_preset(PRESETS[0])
        panel.preset_box.setFocus()
        with qtbot.waitSignal(panel.preset_box.textActivated) as caught:
            qtbot.keyClick(panel.preset_box, Qt.Key.Key_Down)
        assert caught.args == [PRESETS[1]]
