"""What several threads use is closed by the one that leaves it last."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

from stereotrack_core.errors import Cancelled

R = TypeVar("R")


class Shared(Generic[R]):
    """A resource with an owner, and users in other threads.

    The owner closes it without waiting: where somebody still uses it, the last user closes it when
    leaving.

    Parameters
    ----------
    resource : object
    close : callable
        Closes the resource; called once, in whichever thread is the last.

    Attributes
    ----------
    resource : object
        For its owner, who knows whether it is closed.
    """

    def __init__(self, resource: R, close: Callable[[], object]) -> None:
        self.resource = resource
        self._close = close
        self._lock = threading.Lock()
        self._users = 0
        self._unwanted = False

    @property
    def wanted(self) -> bool:
        """Whether its owner has not closed it."""
        return not self._unwanted

    @contextmanager
    def used(self) -> Iterator[R]:
        """The resource, which stays open meanwhile.

        Raises
        ------
        Cancelled
            Where its owner does not want it any more.
        """
        resource = self.enter()
        try:
            yield resource
        finally:
            self.leave()

    def enter(self) -> R:
        """Begin to use the resource; see :meth:`used`."""
        with self._lock:
            if self._unwanted:
                raise Cancelled
            self._users += 1
        return self.resource

    def leave(self) -> None:
        """No longer use it; once for every :meth:`enter`."""
        with self._lock:
            self._users -= 1
            last = self._unwanted and not self._users
        if last:
            self._close()

    def close(self) -> None:
        """Let nobody else begin to use it, and have it closed; a second time does nothing."""
        with self._lock:
            last = not self._unwanted and not self._users
            self._unwanted = True
        if last:
            self._close()
