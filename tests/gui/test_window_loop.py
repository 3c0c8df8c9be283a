"""The loop that the window hands to the session."""

import threading

from PySide6.QtCore import QCoreApplication, QEvent, QObject

from app.context import window_loop
from app.session.changes import Changes, Part


def test_what_a_thread_posts_is_called_in_the_window_s(qtbot):
    loop, called = window_loop(QObject()), []
    thread = threading.Thread(
        target=loop.post, args=(lambda: called.append(threading.current_thread()),)
    )
    thread.start()
    thread.join()
    assert called == []
    qtbot.waitUntil(lambda: called == [threading.main_thread()])


def test_an_object_of_qt_that_is_gone_is_told_nothing(qapp):
    class Panel(QObject):
        told = 0

        def show(self):
            Panel.told += 1

    changes, panel = Changes(window_loop(qapp)), Panel()
    changes.watch(Part.RUNS, panel.show)
    changes.tell(Part.RUNS)
    panel.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    changes.tell(Part.RUNS)
    assert Panel.told == 1
