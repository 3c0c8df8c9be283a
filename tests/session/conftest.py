"""A session without a window."""

from types import SimpleNamespace

import pytest

from app.session.changes import Changes, Part
from app.session.jobs import Processes, TaskList
from app.session.messages import message_of
from app.session.session import Session
from app.session.view_state import ViewState
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from tests.session.plain_loop import Kept, PlainLoop

FRAMES = 8


@pytest.fixture(scope="session")
def small_recording(tmp_path_factory):
    """Two small stereo views of a person in the T pose, rendered once."""
    folder = tmp_path_factory.mktemp("recordings") / "small"
    options = SceneOptions().replaced(width=160, height=120, focal=100)
    simulation = Simulation("P2", "t-pose", frames=FRAMES, views="NS", seed=3, options=options)
    simulate(folder, simulation)
    return folder


@pytest.fixture(scope="session")
def processes():
    made = Processes()
    yield made
    made.close()


@pytest.fixture
def plain():
    return PlainLoop()


@pytest.fixture
def failed():
    """What jobs have failed of."""
    return []


@pytest.fixture
def tasks(plain, failed):
    made = TaskList(plain.loop, failed.append, lambda: None)
    yield made
    made.shutdown()


@pytest.fixture
def shown(plain, processes, tmp_path):
    """A session, the loop that it lives in, and the messages that a person would see."""
    messages, changes = [], Changes(plain.loop)
    tasks = TaskList(
        plain.loop,
        lambda error: messages.append(message_of(error)),
        lambda: changes.tell(Part.TASKS),
    )
    kept = Kept(projects_folder=str(tmp_path / "projects"))
    state = ViewState(changes.tell, lambda: False)
    session = Session(changes, messages.append, tasks, state, kept, processes)
    yield SimpleNamespace(
        session=session, state=state, messages=messages, until=plain.until, tasks=tasks, kept=kept
    )
    session.close()
