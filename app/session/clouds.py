"""The measured points of the frame that is shown, made in the background when asked for."""

from __future__ import annotations

from collections import OrderedDict

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.tuning.sources import NumberedReader

from ..services.failures import message_of
from ..services.tasks.newest import NewestWins
from ..services.tasks.shared import Shared

_KEPT = 12


class _Measuring:
    """Measures points of one recording in one thread, which alone has the chain.

    Another recording gets another one of these, so that a thread that is late has nothing to do
    with it. Once the reader is closed the work ends with the next images.
    """

    def __init__(self, recording: Recording, reader: Shared[FrameReader]) -> None:
        self._recording, self._reader = recording, reader
        self._chain: DepthChain | None = None

    def __call__(self, question: tuple[DepthParameters, int]) -> Cloud:
        """Make one cloud."""
        parameters, frame = question
        with self._reader.used() as reader:
            pictures = NumberedReader(reader, self)
            if self._chain is None or self._chain.parameters != parameters:
                self.close()
                self._chain = DepthChain(self._recording, parameters)
                try:
                    self._chain.learn_background(pictures, range(reader.frame_count))
                except BaseException:
                    self.close()  # it has learned a part at most
                    raise
            return self._chain.process(pictures.frame_set(frame))

    def go_on(self) -> None:
        """Raise :class:`Cancelled` where another recording is measured by now."""
        if not self._reader.wanted:
            raise Cancelled

    def close(self) -> None:
        """End the chain's threads."""
        chain, self._chain = self._chain, None
        if chain is not None:
            chain.close()


class CloudPresenter(QObject):
    """Clouds by frame and parameters; the newest question wins, the last few are kept.

    Signals
    -------
    measured : Cloud
        A cloud that was asked for is there.
    message : Message
        Why there is none.
    """

    measured = Signal(object)
    message = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._reader: Shared[FrameReader] | None = None
        self._worker: NewestWins | None = None
        self._parameters = DepthParameters()
        self._clouds: OrderedDict[tuple[DepthParameters, int], Cloud] = OrderedDict()
        self._failed: set[tuple[DepthParameters, int]] = set()

    @property
    def reader(self) -> Shared[FrameReader] | None:
        """Reader of the images in grey, as the tracker sees them."""
        return self._reader

    def set_recording(self, recording: Recording | None) -> None:
        """Measure another recording; views without depth give nothing."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None
        if self._reader is not None:
            self._reader.close()
            self._reader = None
        self._clouds.clear()
        self._failed.clear()
        names = [view.name for view in recording.views if view.kind != "mono"] if recording else []
        if recording is not None and names:
            reader = FrameReader(recording, views=names, colour=False)
            self._reader = Shared(reader, reader.close)
            measuring = _Measuring(recording, self._reader)
            self._worker = NewestWins(measuring, "measure points", measuring.close)
            self._worker.answered.connect(self._on_measured)
            self._worker.failed.connect(self._on_failed)

    @property
    def parameters(self) -> DepthParameters:
        """How points are measured."""
        return self._parameters

    def set_parameters(self, parameters: DepthParameters) -> None:
        """Measure with other parameters from now on."""
        self._parameters = parameters

    @property
    def available(self) -> bool:
        """Whether the recording has views that give depth."""
        return self._worker is not None

    def cloud(self, frame: int, parameters: DepthParameters | None = None) -> Cloud | None:
        """The cloud of a frame, if it is there already; with other parameters on request."""
        return self._clouds.get((parameters or self._parameters, frame))

    def ask(self, frame: int, parameters: DepthParameters | None = None) -> None:
        """Have the cloud of a frame made; :attr:`measured` tells when it is there."""
        key = (parameters or self._parameters, frame)
        if self._worker is not None and key not in self._clouds and key not in self._failed:
            self._worker.ask(key)

    def keep(self, cloud: Cloud, parameters: DepthParameters) -> None:
        """Keep a cloud that was made elsewhere, by the tracker."""
        self._clouds[parameters, cloud.frame] = cloud
        self._clouds.move_to_end((parameters, cloud.frame))
        while len(self._clouds) > _KEPT:
            self._clouds.popitem(last=False)

    def given_up(self, frame: int, parameters: DepthParameters | None = None) -> bool:
        """Whether there is none to wait for."""
        return self._worker is None or (parameters or self._parameters, frame) in self._failed

    def settled(self) -> bool:
        """Whether nothing is being made."""
        return self._worker is None or self._worker.idle()

    @Slot(object, object)
    def _on_measured(self, question: tuple[DepthParameters, int], cloud: Cloud) -> None:
        self.keep(cloud, question[0])
        self.measured.emit(cloud)

    @Slot(object, object)
    def _on_failed(self, question: tuple[DepthParameters, int], error: Exception) -> None:
        first = not self._failed
        self._failed.add(question)
        if first:
            self.message.emit(message_of(error))
        self.measured.emit(None)
