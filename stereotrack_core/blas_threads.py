"""Linear algebra and OpenCV on one thread, for as long as anybody needs it."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import scipy
from threadpoolctl import ThreadpoolController


class OneBlasThread:
    """Holds the process's BLAS and OpenCV to one thread while at least one holder is left.

    Matrices of some tens of columns gain nothing from a second thread and lose much on a busy
    machine; and the last bits of a sum depend on how many threads made it. Views are measured side
    by side: OpenCV's own threads cost a run 8 % of its processor time, and win none. The number of
    threads belongs to the process, so holders that overlap have to be counted: were each to restore
    what it found, the first to leave would give the threads back under the feet of the others.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._holders: set[object] = set()
        self._restoring: Any = None
        self._controller: ThreadpoolController | None = None
        self._opencv = 1

    def hold(self) -> Callable[[], None]:
        """Begin to hold; returns what ends it, which may be called more than once."""
        holder = object()
        with self._lock:
            if not self._holders:
                self._restoring = self._limited()
            self._holders.add(holder)

        def release() -> None:
            with self._lock:
                if holder in self._holders:
                    self._holders.remove(holder)
                    if not self._holders:
                        self._restoring.restore_original_limits()
                        cv2.setNumThreads(self._opencv)

        return release

    @contextmanager
    def __call__(self) -> Iterator[None]:
        """Hold during a block."""
        release = self.hold()
        try:
            yield
        finally:
            release()

    def _limited(self) -> Any:
        # Looking for the libraries takes milliseconds, a live fit only some tens of them.
        if self._controller is None:
            _ = scipy.linalg  # loads its BLAS, which a limit only reaches once it is loaded
            self._controller = ThreadpoolController()
        self._opencv = cv2.getNumThreads()
        cv2.setNumThreads(1)
        return self._controller.limit(limits=1, user_api="blas")


one_blas_thread = OneBlasThread()
