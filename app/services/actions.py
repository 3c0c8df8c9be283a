"""Every command once: name, shortcut, icon, tooltip, what it does, why it is disabled."""

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

from ..widgets.redraw import later
from ..widgets.style.theme import icon_named

_SHORTCUTS = "shortcuts"
_SOON_MS = 30  # a frame step or a click changes things several times, and asking takes a while


@dataclass(frozen=True)
class Command:
    """One thing that the workbench can do."""

    id: str  # name under which the shortcut is stored; never changes
    menu: str  # menu that it stands in, with submenus after a slash
    text: str
    tip: str
    run: Callable[[], object]
    shortcut: str = ""  # key sequence it has unless the person chooses another
    icon: str = ""
    why_not: Callable[[], str] = str  # why it cannot be done now, as a sentence; empty where it can
    checked: Callable[[], bool] | None = None
    """For commands that switch something: whether it is on."""
    section: bool = False  # whether a separator stands before it in the menu
    says: Callable[[], str] | None = None
    """What it is called now, where that changes: ``Undo Place left elbow``."""
    shown: Callable[[], bool] = lambda: True  # whether it stands in its menu and in the palette now
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
        run: Callable[[], object],
        shortcut: str = "",
        icon: str = "",
        **more: Any,
    ) -> Command:
        """A command of this menu; `more` are further attributes of :class:`Command`."""
        named = {"shortcut": shortcut, "icon": icon, "why_not": self.why_not, **more}
        return Command(name, self.title, text, tip, run, **named)


_UNDO_REDO = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
_TEXT_FIELDS = (QLineEdit, QAbstractSpinBox, QTextEdit, QPlainTextEdit)
_FIELDS = (*_TEXT_FIELDS, QComboBox)
_FUNCTION_KEYS = range(Qt.Key.Key_F1, Qt.Key.Key_F35 + 1)
_WITH_KEYS = (
    Qt.KeyboardModifier.ControlModifier
    | Qt.KeyboardModifier.AltModifier
    | Qt.KeyboardModifier.MetaModifier
)


def _is_edited(field: QObject) -> bool:
    """Whether undo and redo are for the text: some was typed that no one has taken yet."""
    if isinstance(field, QTextEdit | QPlainTextEdit):
        return field.document().isUndoAvailable() or field.document().isRedoAvailable()
    line = field.lineEdit() if isinstance(field, QAbstractSpinBox | QComboBox) else field
    if not isinstance(line, QLineEdit):
        return False
    around = line.parentWidget()
    in_a_table = around is not None and isinstance(around.parentWidget(), QAbstractItemView)
    return in_a_table or line.isUndoAvailable() or line.isRedoAvailable()


def _is_for_text(field: QObject, event: QKeyEvent) -> bool:
    """Keys in a text field are for the text, but for those with Ctrl or Alt.

    Undo and redo are for the text where there is something of it to be undone.
    """
    if any(event.matches(key) for key in _UNDO_REDO) and not _is_edited(field):
        event.ignore()  # a field would accept it, and do nothing
        return True
    command = bool(event.modifiers() & _WITH_KEYS)
    if not isinstance(field, _TEXT_FIELDS) or command or event.key() in _FUNCTION_KEYS:
        return False
    event.accept()
    return True


class ActionRegistry(QObject):
    """The commands as actions of a window; says which of them can be done, and why not."""

    refreshed = Signal()

    def __init__(self, window: QWidget, settings: QSettings, say: Callable[[str], object]) -> None:
        super().__init__(window)
        self._say_refusal = say
        self._window, self._settings = window, settings
        self._soon = later(self, self.refresh, _SOON_MS)
        self._commands: dict[str, Command] = {}
        self._actions: dict[str, QAction] = {}
        self._keys: dict[str, str] = {}  # as they are stored
        self._said: dict[str, tuple[object, ...]] = {}
        window.installEventFilter(self)
        app = QApplication.instance()
        if isinstance(app, QApplication):
            app.focusChanged.connect(self._on_focus)

    @property
    def commands(self) -> tuple[Command, ...]:
        return tuple(self._commands.values())

    def add(self, commands: Iterable[Command]) -> None:
        for command in commands:
            self._commands[command.id] = command
            self._actions[command.id] = self._action(command)
            stored = self._settings.value(f"{_SHORTCUTS}/{command.id}")
            keys = command.shortcut if stored is None else str(stored)
            self._give_keys(command, keys)

    def action(self, name: str) -> QAction:
        return self._actions[name]

    def command(self, name: str) -> Command:
        return self._commands[name]

    def refresh(self, menu: str = "") -> None:
        """Find out what can be done now: in all menus, or in one and those below it."""
        if not menu:
            self._soon.stop()
        for name, command in self._commands.items():
            if not command.menu.startswith(menu):
                continue
            action, why_not = self._actions[name], command.why_not()
            named = command.says() if command.says is not None else ""
            if command.checked is not None:
                action.setChecked(command.checked())
            said = (named, why_not, command.shown(), self._keys[name])
            # What has not changed is not said again: it takes time.
            if self._said.get(name) != said:
                self._said[name] = said
                action.setVisible(said[2])
                self._say(command, action, named, why_not)
        if not menu:
            self.refreshed.emit()

    @Slot()
    def refresh_soon(self) -> None:
        """Find out what can be done now, once for all that changes in the next moment."""
        if not self._soon.isActive():
            self._soon.start()

    def settled(self) -> bool:
        return not self._soon.isActive()

    @Slot(QWidget, QWidget)
    def _on_focus(self, _old: QWidget | None, new: QWidget | None) -> None:
        if isinstance(new, _FIELDS):
            new.installEventFilter(self)
        if new is not None and isinstance(new.window(), QDockWidget):  # one that floats
            new.window().installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if not isinstance(event, QKeyEvent):
            return False
        if isinstance(watched, _FIELDS):
            return event.type() == QEvent.Type.ShortcutOverride and _is_for_text(watched, event)
        if event.type() == QEvent.Type.ShortcutOverride and self._soon.isActive():
            self.refresh()  # a list would take the key of what can be done only now
        # a key that reaches the window was of no use to anything in it
        modifiers = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        keys = QKeySequence(QKeyCombination(modifiers, Qt.Key(event.key())))
        return event.type() == QEvent.Type.KeyPress and self._on_unused(keys.toString())

    def _on_unused(self, keys: str) -> bool:
        """Say why the command of these keys cannot be done; do it, if meanwhile it can."""
        named = [name for name, used in self._keys.items() if keys and used == keys]
        # of two commands with the same keys the one that comes second has the usual meaning
        name = min(named, key=lambda one: self._commands[one].goes_first, default=None)
        # a list does what Enter means there, and hands the key on nonetheless
        takes = (*_TEXT_FIELDS, QAbstractItemView) if keys == "Return" else _TEXT_FIELDS
        typing = isinstance(QApplication.focusWidget(), takes)
        if name is None or typing or self._actions[name].isEnabled():
            return False
        if why_not := self._commands[name].why_not():
            self._say_refusal(f"{self._commands[name].title}: unavailable. {why_not}")
        else:
            self.refresh()
            self._actions[name].trigger()
        return True

    def set_shortcut(self, name: str, keys: str) -> None:
        command = self._commands[name]
        if keys == command.shortcut:
            self._settings.remove(f"{_SHORTCUTS}/{name}")
        else:
            self._settings.setValue(f"{_SHORTCUTS}/{name}", keys)
        self._give_keys(command, keys)
        self.refresh()

    def shortcut(self, name: str) -> str:
        """Key sequence of a command, as it is stored."""
        return self._keys[name]

    def key_words(self, name: str) -> str:
        """Key sequence of a command, as a person reads it."""
        return QKeySequence(self._keys[name]).toString(QKeySequence.SequenceFormat.NativeText)

    def user_of(self, keys: str, besides: str = "") -> Command | None:
        """Tell which command has a key sequence already, where neither of both goes first."""
        first = besides in self._commands and self._commands[besides].goes_first
        others = (one for one in self.commands if one.id != besides and one.goes_first == first)
        wanted = QKeySequence(keys).toString()
        return next((one for one in others if wanted and self._keys[one.id] == wanted), None)

    def fill(self, bar: QMenuBar, order: Sequence[str]) -> None:
        menus: dict[str, QMenu] = {}

        def menu_at(path: str) -> QMenu:
            if path not in menus:
                parent, _, title = path.rpartition("/")
                menus[path] = (menu_at(parent) if parent else bar).addMenu(title)
                menus[path].setToolTipsVisible(True)
            return menus[path]

        for title in order:
            menu_at(title)
        for command in self._commands.values():
            menu = menu_at(command.menu)
            if command.section and not menu.isEmpty():
                menu.addSeparator()
            menu.addAction(self._actions[command.id])

    def _action(self, command: Command) -> QAction:
        action = QAction(command.text, self._window)
        action.setObjectName(command.id)
        action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        action.setCheckable(command.checked is not None)
        if command.icon:
            action.setIcon(icon_named(command.icon))
        action.triggered.connect(lambda _checked: command.run())
        action.triggered.connect(self.refresh_soon)
        self._window.addAction(action)
        return action

    def _say(self, command: Command, action: QAction, named: str, why_not: str) -> None:
        if named:
            action.setText(named.replace("&", "&&"))
        action.setEnabled(not why_not)
        if command.goes_first:
            self._share_keys(self._keys[command.id])
        words = f"Unavailable: {why_not} {command.tip}" if why_not else command.tip
        action.setStatusTip(words)
        tip = f"{named}. {words}" if named not in {"", command.text} else words
        keys = self.key_words(command.id)
        action.setToolTip(f"{tip}  [{keys}]" if keys else tip)

    def _give_keys(self, command: Command, wanted: str) -> None:
        keys = QKeySequence(wanted).toString()
        before, self._keys[command.id] = self._keys.get(command.id, keys), keys
        action = self._actions[command.id]
        if command.goes_first:  # shown in menus all the same
            action.setText(f"{command.text}\t{self.key_words(command.id)}")
        action.setShortcut(QKeySequence(keys))
        for shared in (before, keys):
            self._share_keys(shared)

    def _share_keys(self, keys: str) -> None:
        """Give keys that two commands have to the one that can be done now."""
        users = [name for name, used in self._keys.items() if keys and used == keys]
        first = {name for name in users if self._commands[name].goes_first}
        taken = any(self._actions[name].isEnabled() for name in first)
        for name in users:
            if name not in first:
                self._actions[name].setShortcut(QKeySequence("" if taken else keys))
