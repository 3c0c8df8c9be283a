"""Libraries on one thread, for as long as anybody needs it."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial

import cv2
import scipy
from threadpoolctl import ThreadpoolController


class OneThread:
    """Holds a library of the process to one thread while at least one holder is left.

    The number of threads belongs to the process, so holders that overlap have to be counted: were
    each to restore what it found, the first to leave would give the threads back under the feet of
    the others. `limit` begins to limit the library, and returns what ends that.
    """

    def __init__(self, limit: Callable[[], Callable[[], object]]) -> None:
        self._lock = threading.Lock()
        self._holders: set[object] = set()
        self._limit = limit
        self._restore: Callable[[], object] = lambda: None

    def hold(self) -> Callable[[], None]:
        """Begin to hold; returns what ends it, which may be called more than once."""
        holder = object()
        with self._lock:
            if not self._holders:
                self._restore = self._limit()
            self._holders.add(holder)

        def release() -> None:
            with self._lock:
                if holder in self._holders:
                    self._holders.remove(holder)
                    if not self._holders:
                        self._restore()

        return release

    @contextmanager
    def __call__(self) -> Iterator[None]:
        """Hold during a block."""
        release = self.hold()
        try:
            yield
        finally:
            release()


@cache
def _blas() -> ThreadpoolController:
    """Looking for the libraries takes milliseconds, a live fit only some tens of them."""
    _ = scipy.linalg  # loads its BLAS, which a limit only reaches once it is loaded
    return ThreadpoolController()


def _limit_opencv() -> Callable[[], object]:
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    return partial(cv2.setNumThreads, before)


one_blas_thread = OneThread(
    lambda: _blas().limit(limits=1, user_api="blas").restore_original_limits
)
"""Matrices of some tens of columns gain nothing from a second thread and lose much on a busy
machine; and the last bits of a sum depend on how many threads made it."""

one_opencv_thread = OneThread(_limit_opencv)
"""Views are measured side by side: with four on two cores, OpenCV's own threads cost a run 5 to 8 %
of its processor time and win none."""
