"""The clouds that attempts share, for the recording that is open."""

from __future__ import annotations

import dataclasses

from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.tuning.clouds import CloudStore

from ...services.tasks.shared import Shared
from ...session.clouds import CloudPresenter
from ...session.document import DocumentPresenter


class StoreKeeper:
    """Makes the store of the open recording when it is first asked for."""

    def __init__(self, document: DocumentPresenter, clouds: CloudPresenter) -> None:
        self._document, self._clouds = document, clouds
        self._store: Shared[CloudStore] | None = None
        self._of: Recording | None = None

    def store(self) -> Shared[CloudStore] | None:
        """Clouds of the open recording; None where nothing gives depth."""
        recording, reader = self._document.recording, self._clouds.reader
        if recording is None or reader is None:
            return None
        if self._store is None or self._of is not recording:
            self.close()
            self._store, self._of = _store_of(recording, reader), recording
        return self._store

    def close(self) -> None:
        """Forget all clouds; who still uses them forgets them in the end."""
        if self._store is not None:
            self._store.close()
        self._store = self._of = None


def _store_of(recording: Recording, reader: Shared[FrameReader]) -> Shared[CloudStore]:
    # the tracker never sees the truth
    store = CloudStore(dataclasses.replace(recording, reference=None), reader.enter())

    def close() -> None:
        store.close()
        reader.leave()

    return Shared(store, close)
