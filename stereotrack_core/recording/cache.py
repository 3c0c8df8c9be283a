"""Pictures in memory, up to a number of bytes; what was not used longest goes first."""

from __future__ import annotations

import threading
from collections import OrderedDict
from typing import Any

from numpy.typing import NDArray

PictureKey = tuple[str, int]


class PictureCache:
    """Pictures by stream and frame number; safe to use from many threads.

    Parameters
    ----------
    limit : int
        Bytes of pixels that are kept at most. One picture that is larger is not kept.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._pictures: OrderedDict[PictureKey, NDArray[Any]] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    @property
    def bytes_used(self) -> int:
        """Bytes of pixels that are kept now."""
        return self._bytes

    def get(self, key: PictureKey) -> NDArray[Any] | None:
        """The picture, or None where it is not kept."""
        with self._lock:
            picture = self._pictures.get(key)
            if picture is not None:
                self._pictures.move_to_end(key)
            return picture

    def __contains__(self, key: PictureKey) -> bool:
        with self._lock:
            return key in self._pictures

    def put(self, key: PictureKey, picture: NDArray[Any]) -> None:
        """Keep a picture, and give up the ones not used longest if there is no room."""
        if picture.nbytes > self._limit:
            return
        with self._lock:
            old = self._pictures.pop(key, None)
            self._bytes += picture.nbytes - (0 if old is None else old.nbytes)
            self._pictures[key] = picture
            while self._bytes > self._limit:
                _, given_up = self._pictures.popitem(last=False)
                self._bytes -= given_up.nbytes

    def clear(self) -> None:
        """Give up everything."""
        with self._lock:
            self._pictures.clear()
            self._bytes = 0
