"""Measured points: each recording is measured with its own cameras, however late a thread is."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

import pytest

from app.session.instant import CloudPresenter
from app.session.work_threads import wait_for_threads
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning import clouds

PATIENCE_S = 300.0


@dataclass(eq=False)
class Points:
    """In place of a cloud: says which chain has made it."""

    frame: int
    chain: Chain
    points: None = None
    pixels: None = None
    depths: None = None
    view_names: tuple = ("N",)


@dataclass(eq=False)
class Chain:
    """In place of a depth chain; learns until it is let go."""

    parameters: DepthParameters
    go: threading.Event
    learns = False
    begun: threading.Event = field(default_factory=threading.Event)
    closed_in: list[threading.Thread] = field(default_factory=list)

    def learn_background(self, *_learned_from):
        self.begun.set()
        assert self.go.wait(PATIENCE_S)

    def measured(self, frame_set):
        return frame_set.index

    def fused(self, frame):
        return Points(frame, self)

    def close(self):
        self.closed_in.append(threading.current_thread())


@pytest.fixture
def chains(monkeypatch):
    """Chains in the order in which they were made; the first is slow."""
    made = []

    def make(_recording, parameters, **_keywords):
        go = threading.Event()
        if made:
            go.set()
        made.append(Chain(parameters, go))
        return made[-1]

    monkeypatch.setattr(clouds, "DepthChain", make)
    return made


@pytest.fixture
def presenter(tasks):
    told = []
    made = CloudPresenter(lambda _part, cloud=None: told.append(cloud), tasks, Settings)
    made.told = told
    yield made
    made.set_recording(None)


def test_a_frame_in_which_no_view_gives_depth_is_measured_once(
    plain, presenter, chains, small_recording
):
    presenter.set_recording(open_recording(small_recording))
    presenter.ask(0)
    plain.until(lambda: bool(chains))
    chains[0].go.set()
    plain.until(lambda: len(presenter.told) == 1)
    assert presenter.whole(0)
    presenter.ask(0)
    assert presenter.settled()


def test_a_late_thread_has_nothing_to_do_with_the_next_recording(
    plain, presenter, chains, failed, small_recording
):
    first, second = open_recording(small_recording), open_recording(small_recording)
    presenter.set_recording(first)
    presenter.ask(0)
    plain.until(lambda: bool(chains))
    assert chains[0].begun.wait(PATIENCE_S)
    (late,) = (one for one in threading.enumerate() if one.name == "measure points")
    presenter.set_recording(second)
    assert late.is_alive(), "the window waits for nobody"
    presenter.ask(0)
    plain.until(lambda: len(presenter.told) == 1)
    chains[0].go.set()
    wait_for_threads(PATIENCE_S)
    presenter.ask(1)
    plain.until(lambda: len(presenter.told) == 2)
    plain.once()
    assert [one.chain for one in presenter.told] == [chains[1], chains[1]]
    assert len(chains) == 2
    assert chains[0].closed_in == [late], "who has used it alone has closed it"
    assert chains[1].closed_in == []
    assert failed == []
    assert not presenter.given_up(0)
