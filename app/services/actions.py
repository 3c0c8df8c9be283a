"""Every command once: name, shortcut, icon, tooltip, what it does, why it is disabled."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QEvent, QKeyCombination, QObject, QSettings, Qt, Signal, Slot
from PySide6.QtGui import QAction, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QLineEdit,
    QMenu,
    QMenuBar,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

from ..widgets.redraw import RedrawQueue
from ..widgets.style.theme import set_icon

_SHORTCUTS = "shortcuts"


@dataclass(frozen=True)
class Command:
    """One thing that the workbench can do."""

    id: str
    """Name under which the shortcut is stored; never changes."""
    menu: str
    """Menu that it stands in, with submenus after a slash."""
    text: str
    """What it is called in menus and the palette."""
    tip: str
    """What it does, in a sentence."""
    run: Callable[[], None]
    """Does it."""
    shortcut: str = ""
    """Key sequence it has unless the person chooses another."""
    icon: str = ""
    """Name of an icon in the resources."""
    why_not: Callable[[], str] = str
    """Why it cannot be done now, as a sentence; empty where it can."""
    checked: Callable[[], bool] | None = None
    """For commands that switch something: whether it is on."""
    section: bool = False
    """Whether a separator stands before it in the menu."""
    says: Callable[[], str] | None = None
    """What it is called now, where that changes: ``Undo Place left elbow``."""
    shown: Callable[[], bool] = lambda: True
    """Whether it stands in its menu and in the palette now."""
    goes_first: bool = False
    """Whether it takes its keys from another command of the same keys, while it can be done."""

    @property
    def title(self) -> str:
        """What it is called where its menu is not seen: with the submenu that gives it sense."""
        text = self.says() if self.says is not None else self.text
        submenu = self.menu.replace("&", "").partition("/")[2].replace("/", ", ")
        return f"{submenu}: {text}" if submenu else text

    @property
    def place(self) -> str:
        """Where it stands in the menus, as a person reads it."""
        return self.menu.replace("&", "").replace("/", " › ")


@dataclass(frozen=True)
class Menu:
    """A menu, and why its commands cannot be done now where they do not say that themselves."""

    title: str
    why_not: Callable[[], str] = str

    def command(
        self,
        name: str,
        text: str,
        tip: str,
        run: Callable[[], None],
        shortcut: str = "",
        icon: str = "",
        **more: Any,
    ) -> Command:
        """A command of this menu; `more` are further attributes of :class:`Command`."""
        named = {"shortcut": shortcut, "icon": icon, "why_not": self.why_not, **more}
        return Command(name, self.title, text, tip, run, **named)


_UNDO_REDO = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
_TEXT_FIELDS = (QLineEdit, QAbstractSpinBox, QTextEdit, QPlainTextEdit)
_WITH_KEYS = (
    Qt.KeyboardModifier.ControlModifier
    | Qt.KeyboardModifier.AltModifier
    | Qt.KeyboardModifier.MetaModifier
)


def _is_edited(field: QObject) -> bool:
    """Whether undo and redo are for the text: some was typed that no one has taken yet."""
    if isinstance(field, QTextEdit | QPlainTextEdit):
        document = field.document()
        return document.isUndoAvailable() or document.isRedoAvailable()
    line = field.lineEdit() if isinstance(field, QAbstractSpinBox | QComboBox) else field
    if not isinstance(line, QLineEdit):
        return False
    around = line.parentWidget()
    in_a_table = around is not None and isinstance(around.parentWidget(), QAbstractItemView)
    return in_a_table or line.isUndoAvailable() or line.isRedoAvailable()


class _Typing(QObject):
    """Keys that are pressed in a text field are for the text, but for those with Ctrl or Alt.

    Undo and redo are for the text where there is something of it to be undone.
    """

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
            return False
        if any(event.matches(key) for key in _UNDO_REDO) and not _is_edited(watched):
            event.ignore()  # a field would accept it, and do nothing
            return True
        if not isinstance(watched, _TEXT_FIELDS):
            return False
        command = bool(event.modifiers() & _WITH_KEYS)
        if command or Qt.Key.Key_F1 <= event.key() <= Qt.Key.Key_F35:
            return False
        event.accept()
        return True


class _Unused(QObject):
    """Hears the keys that nothing in a window had a use for."""

    def __init__(self, heard: Callable[[QKeySequence], bool], parent: QObject) -> None:
        super().__init__(parent)
        self._heard = heard

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if event.type() != QEvent.Type.KeyPress or not isinstance(event, QKeyEvent):
            return False
        modifiers = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        return self._heard(QKeySequence(QKeyCombination(modifiers, Qt.Key(event.key()))))


class ActionRegistry(QObject):
    """The commands as actions of a window; says which of them can be done, and why not.

    Signals
    -------
    refreshed : ()
        What can be done now has been found out again.
    """

    refreshed = Signal()

    def __init__(
        self,
        window: QWidget,
        settings: QSettings,
        redraw: RedrawQueue,
        say: Callable[[str], object],
    ) -> None:
        super().__init__(window)
        self._say_refusal = say
        self._window, self._settings, self._redraw = window, settings, redraw
        self._commands: dict[str, Command] = {}
        self._actions: dict[str, QAction] = {}
        self._keys: dict[str, QKeySequence] = {}
        self._said: dict[str, tuple[str, str, str]] = {}
        self._typing, self._unused = _Typing(self), _Unused(self._on_unused, self)
        window.installEventFilter(self._unused)
        app = QApplication.instance()
        if isinstance(app, QApplication):
            app.focusChanged.connect(self._on_focus)

    @property
    def commands(self) -> tuple[Command, ...]:
        """All commands, in order of their declaration."""
        return tuple(self._commands.values())

    def add(self, commands: Iterable[Command]) -> None:
        """Make actions of commands.

        Raises
        ------
        ValueError
            If there is a command of that id already.
        """
        for command in commands:
            if command.id in self._commands:
                raise ValueError(f"two commands have the id {command.id!r}")
            self._commands[command.id] = command
            self._actions[command.id] = self._action(command)
            stored = self._settings.value(f"{_SHORTCUTS}/{command.id}")
            keys = command.shortcut if stored is None else str(stored)
            self._give_keys(command, QKeySequence(keys))

    def action(self, name: str) -> QAction:
        """Action of a command."""
        return self._actions[name]

    def command(self, name: str) -> Command:
        """A command by its id."""
        return self._commands[name]

    def refresh(self, menu: str = "") -> None:
        """Find out what can be done now: in all menus, or in one and those below it."""
        for name, command in self._commands.items():
            if not command.menu.startswith(menu):
                continue
            action = self._actions[name]
            why_not = command.why_not()
            named = command.says() if command.says is not None else ""
            if named:
                action.setText(named.replace("&", "&&"))
            action.setVisible(command.shown())
            if command.checked is not None:
                action.setChecked(command.checked())
            said = (named, why_not, self.key_words(name))
            # What has not changed is not said again: it takes time.
            if self._said.get(name) != said:
                self._said[name] = said
                self._say(command, action, *said)
        if not menu:
            self.refreshed.emit()

    @Slot()
    def refresh_soon(self, _what: object = None) -> None:
        """Find out what can be done now, when it is its turn among what is drawn."""
        self._redraw.soon(self.refresh)

    @Slot(QWidget, QWidget)
    def _on_focus(self, _old: QWidget | None, new: QWidget | None) -> None:
        if isinstance(new, (*_TEXT_FIELDS, QComboBox)):
            new.installEventFilter(self._typing)
        if new is not None and isinstance(new.window(), QDockWidget):  # one that floats
            new.window().installEventFilter(self._unused)

    def _on_unused(self, keys: QKeySequence) -> bool:
        """Say why the command of these keys cannot be done; do it, if meanwhile it can."""
        named = [name for name, used in self._keys.items() if used == keys]
        # of two commands with the same keys the one that comes second has the usual meaning
        name = min(named, key=lambda one: self._commands[one].goes_first, default=None)
        typing = isinstance(QApplication.focusWidget(), _TEXT_FIELDS)
        if name is None or typing or self._actions[name].isEnabled():
            return False
        command = self._commands[name]
        if why_not := command.why_not():
            self._say_refusal(f"{command.title}: unavailable. {why_not}")
        else:
            self.refresh()
            self._actions[name].trigger()
        return True

    def set_shortcut(self, name: str, keys: str) -> None:
        """Give a command another shortcut, and keep it for next time."""
        command = self._commands[name]
        if keys == command.shortcut:
            self._settings.remove(f"{_SHORTCUTS}/{name}")
        else:
            self._settings.setValue(f"{_SHORTCUTS}/{name}", keys)
        self._give_keys(command, QKeySequence(keys))
        self.refresh()

    def shortcut(self, name: str) -> str:
        """Key sequence of a command, as it is stored."""
        return self._keys[name].toString()

    def key_words(self, name: str) -> str:
        """Key sequence of a command, as a person reads it."""
        return self._keys[name].toString(QKeySequence.SequenceFormat.NativeText)

    def user_of(self, keys: str, besides: str = "") -> Command | None:
        """Tell which command has a key sequence already, where neither of both goes first."""
        wanted = QKeySequence(keys)
        if wanted.isEmpty():
            return None
        first = besides in self._commands and self._commands[besides].goes_first
        for name, used in self._keys.items():
            command = self._commands[name]
            if name != besides and used == wanted and command.goes_first == first:
                return command
        return None

    def fill(self, bar: QMenuBar, order: Sequence[str]) -> None:
        """Build the menus, in this order, from what the commands say about themselves."""
        menus: dict[str, QMenu] = {}
        for title in order:
            self._menu(bar, menus, title)
        for command in self._commands.values():
            menu = self._menu(bar, menus, command.menu)
            if command.section and not menu.isEmpty():
                menu.addSeparator()
            menu.addAction(self._actions[command.id])

    def _menu(self, bar: QMenuBar, menus: dict[str, QMenu], path: str) -> QMenu:
        if path not in menus:
            parent, _, title = path.rpartition("/")
            if parent:
                menus[path] = self._menu(bar, menus, parent).addMenu(title)
            else:
                menus[path] = bar.addMenu(title)
            menus[path].setToolTipsVisible(True)
        return menus[path]

    def _action(self, command: Command) -> QAction:
        action = QAction(command.text, self._window)
        action.setObjectName(command.id)
        action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        action.setCheckable(command.checked is not None)
        if command.icon:
            set_icon(action, command.icon)
        action.triggered.connect(lambda _checked=False, run=command.run: self._run(run))
        self._window.addAction(action)
        return action

    def _say(self, command: Command, action: QAction, named: str, why_not: str, keys: str) -> None:
        action.setEnabled(not why_not)
        if command.goes_first:
            self._share_keys(self._keys[command.id])
        words = f"{command.tip} Unavailable: {why_not}" if why_not else command.tip
        action.setStatusTip(words)
        tip = f"{named}. {words}" if named not in {"", command.text} else words
        action.setToolTip(f"{tip}  [{keys}]" if keys else tip)

    def _give_keys(self, command: Command, keys: QKeySequence) -> None:
        before = self._keys.get(command.id, keys)
        self._keys[command.id] = keys
        action = self._actions[command.id]
        if command.goes_first:  # shown in menus all the same
            action.setText(f"{command.text}\t{self.key_words(command.id)}")
        action.setShortcut(keys)
        for shared in (before, keys):
            self._share_keys(shared)

    def _share_keys(self, keys: QKeySequence) -> None:
        """Give keys that two commands have to the one that can be done now."""
        users = [name for name, used in self._keys.items() if used == keys]
        first = {name for name in users if self._commands[name].goes_first}
        taken = any(self._actions[name].isEnabled() for name in first)
        for name in users:
            if name not in first:
                self._actions[name].setShortcut(QKeySequence() if taken else keys)

    def _run(self, run: Callable[[], None]) -> None:
        run()
        self.refresh()
