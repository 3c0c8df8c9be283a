"""The measured points of the frame that is shown, made in the background when asked for."""

from __future__ import annotations

import dataclasses
from collections import OrderedDict

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.memory import usual_limit
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore, KeptClouds

from ..services.failures import message_of
from ..services.tasks.newest import LatestOnly
from ..services.tasks.shared import Shared

_KEPT = 12


class _Measuring:
    """Takes clouds of one recording from its store, in one thread.

    Another recording gets another one of these, so that a thread that is late has nothing to do
    with it. Once the store is closed the work ends with the next images.
    """

    def __init__(self, store: Shared[CloudStore]) -> None:
        self._store = store
        """Clouds of the open recording; None where nothing gives depth."""
        self._clouds: KeptClouds | None = None

    def __call__(self, question: tuple[DepthParameters, int]) -> Cloud:
        """Make one cloud."""
        parameters, frame = question
        with self._store.used() as store:
            key = CloudKey(parameters, range(store.reader.frame_count))
            if self._clouds is None or self._clouds.key != key:
                self._clouds = store.clouds(key, cancelled=lambda: not self._store.wanted)
            return self._clouds.take(frame)[0]


def _store_of(recording: Recording, reader: Shared[FrameReader]) -> Shared[CloudStore]:
    # the tracker never sees the truth
    unaided = dataclasses.replace(recording, reference=None)
    store = CloudStore(unaided, reader.enter(), limit=usual_limit() // 4)

    def close() -> None:
        store.close()
        reader.leave()

    return Shared(store, close)


class CloudPresenter(QObject):
    """Clouds by frame and parameters; the newest question wins, the last few are kept."""

    measured = Signal(object)
    """A cloud that was asked for is there."""
    message = Signal(object)
    """Why there is none."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.reader: Shared[FrameReader] | None = None
        """Reader of the images in grey, as the tracker sees them."""
        self._store: Shared[CloudStore] | None = None
        self._worker: LatestOnly | None = None
        self.parameters = DepthParameters()
        """How points are measured."""
        self._clouds: OrderedDict[tuple[DepthParameters, int], Cloud] = OrderedDict()
        self._points: tuple[tuple[DepthParameters, int], Cloud] | None = None
        self._failed: set[tuple[DepthParameters, int]] = set()

    def set_recording(self, recording: Recording | None) -> None:
        """Measure another recording; views without depth give nothing."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None
        for shared in (self._store, self.reader):
            if shared is not None:
                shared.close()
        self._store = self.reader = None
        self._clouds.clear()
        self._points = None
        self._failed.clear()
        names = [view.name for view in recording.views if view.kind != "mono"] if recording else []
        if recording is not None and names:
            reader = FrameReader(recording, views=names, colour=False)
            self.reader = Shared(reader, reader.close)
            self._store = _store_of(recording, self.reader)
            self._worker = LatestOnly(_Measuring(self._store), "measure points")
            self._worker.answered.connect(self._on_measured)
            self._worker.failed.connect(self._on_failed)

    def set_parameters(self, parameters: DepthParameters) -> None:
        """Measure with other parameters from now on."""
        self.parameters = parameters

    @property
    def available(self) -> bool:
        """Whether the recording has views that give depth."""
        return self._worker is not None

    def cloud(self, frame: int, parameters: DepthParameters | None = None) -> Cloud | None:
        """The cloud of a frame, if it is there already; with other parameters on request.

        That of the frame which the tracker has just done may be without depth images.
        """
        key = parameters or self.parameters, frame
        points = self._points[1] if self._points is not None and self._points[0] == key else None
        return self._clouds.get(key, points)

    def whole(self, frame: int) -> bool:
        """Whether the cloud of a frame is there with its depth images."""
        return (self.parameters, frame) in self._clouds

    def ask(self, frame: int, parameters: DepthParameters | None = None) -> None:
        """Have the cloud of a frame made; :attr:`measured` tells when it is there."""
        key = (parameters or self.parameters, frame)
        if self._worker is not None and key not in self._clouds and key not in self._failed:
            self._worker.ask(key)

    def keep(self, cloud: Cloud, parameters: DepthParameters) -> None:
        """Keep a cloud that was made elsewhere, by the tracker; without depth images one alone."""
        if not cloud.depths and cloud.view_names:
            self._points = (parameters, cloud.frame), cloud
        else:
            self._keep(cloud, parameters)

    def _keep(self, cloud: Cloud, parameters: DepthParameters) -> None:
        self._clouds[parameters, cloud.frame] = cloud
        self._clouds.move_to_end((parameters, cloud.frame))
        while len(self._clouds) > _KEPT:
            self._clouds.popitem(last=False)

    def given_up(self, frame: int, parameters: DepthParameters | None = None) -> bool:
        """Whether there is none to wait for."""
        return self._worker is None or (parameters or self.parameters, frame) in self._failed

    def settled(self) -> bool:
        """Whether nothing is being made."""
        return self._worker is None or self._worker.settled()

    @Slot(object, object)
    def _on_measured(self, question: tuple[DepthParameters, int], cloud: Cloud) -> None:
        self._keep(cloud, question[0])
        self.measured.emit(cloud)

    @Slot(object, object)
    def _on_failed(self, question: tuple[DepthParameters, int], error: Exception) -> None:
        first = not self._failed
        self._failed.add(question)
        if first:
            self.message.emit(message_of(error))
        self.measured.emit(None)
