"""Work in threads of its own tells the window how it ended."""

import pytest

from app.tasks.task import TaskList
from app.tuning.worker import AttemptWorker
from stereotrack_core.errors import Cancelled, InputError


def _ends(task, told):
    """Connect when the work is over already, as somebody does who is late."""
    assert task.join(10.0)
    for name in ("stopped", "failed", "finished", "ended"):
        getattr(task, name).connect(lambda *_what, name=name: told.append(name))


@pytest.mark.parametrize(
    ("error", "how"),
    [(None, "finished"), (InputError("x", remedy="y"), "failed"), (Cancelled(), "stopped")],
)
def test_who_connects_after_the_end_is_told_as_well(qtbot, error, how):
    def work(_task):
        if error is not None:
            raise error
        return 3

    tasks, told, done = TaskList(), [], []
    _ends(tasks.begin("something quick", work, done.append), told)
    assert told == []
    qtbot.waitUntil(lambda: "ended" in told, timeout=10_000)
    assert told == [how, "ended"]
    assert done == ([3] if error is None else [])
    assert tasks.tasks == ()


def test_an_attempt_begins_when_its_end_can_be_told(qtbot):
    worker, told = AttemptWorker((), store=None), []
    assert not worker.done
    worker.ended.connect(lambda: told.append("ended"))
    worker.start()
    qtbot.waitUntil(lambda: told == ["ended"], timeout=10_000)
    assert worker.done
