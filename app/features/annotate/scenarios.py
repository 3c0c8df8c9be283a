"""Stretches of frames that are kept under a name, over which results are compared."""

from PySide6.QtWidgets import QComboBox

from stereotrack_core.counting import frames_in_words
from stereotrack_core.project.entries import delete_entry
from stereotrack_core.project.scenarios import keep_scenario
from stereotrack_core.project.schema import SCENARIO

from ...services.actions import Command, Menu
from ...session.session import unless
from ...widgets.forms.form_dialog import ask_for_text
from .panels import AnnotationPanels


def scenario_commands(p: AnnotationPanels, menu: str) -> list[Command]:
    """Name the selected frames, and forget a name."""

    def names() -> tuple[str, ...]:
        return p.project.scenarios.names() if p.project is not None else ()

    def no_selection() -> str:
        none = "Select frames in the timeline first: drag in its ruler."
        return p.no_edit() or unless(p.timeline.selection, none)

    def no_names() -> str:
        return p.no_edit() or unless(names(), "No stretch has a name in this project.")

    def ask_for_name() -> None:
        chosen = p.selection()
        words = f"Name of {frames_in_words(chosen.frames)}, such as crossing or fast:"

        def use(name: str) -> None:
            p.edit_selection(lambda _, own: keep_scenario(name, own.frames), chosen)

        dialog = ask_for_text(p.window, "Name stretch", words, use)
        dialog.setComboBoxItems(["", *names()])
        dialog.setComboBoxEditable(True)
        dialog.findChildren(QComboBox)[0].setFocus()

    def ask_what_to_forget() -> None:
        use = lambda name: p.edit_selection(lambda *_: delete_entry(SCENARIO, name))  # noqa: E731
        dialog = ask_for_text(p.window, "Forget named stretch", "All stretches of this name:", use)
        dialog.setComboBoxItems(list(names()))
        dialog.setOkButtonText("Forget")

    command = Menu(menu, p.no_edit).command
    return [
        command("annotate-name-stretch", "Name stretch …", "Keep the selected frames under a name, "
                "such as crossing. Several stretches may have the same name; comparisons, studies "
                "and reports have a row for each name.", ask_for_name, why_not=no_selection,
                section=True),
        command("annotate-forget-stretch", "Forget named stretch …", "Remove a name and its "
                "stretches from the project. You can undo this.", ask_what_to_forget,
                why_not=no_names),
    ]  # fmt: skip
