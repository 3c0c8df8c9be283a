"""The clouds that attempts share, for the recording that is open."""

from __future__ import annotations

import dataclasses

from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.tuning.clouds import CloudStore

from ..presenters.clouds import CloudPresenter
from ..presenters.document import DocumentPresenter


class StoreKeeper:
    """Makes the store of the open recording when it is first asked for."""

    def __init__(self, document: DocumentPresenter, clouds: CloudPresenter) -> None:
        self._document, self._clouds = document, clouds
        self._store: CloudStore | None = None
        self._of: Recording | None = None

    def store(self) -> CloudStore | None:
        """Clouds of the open recording; None where nothing gives depth."""
        recording, reader = self._document.recording, self._clouds.reader
        if recording is None or reader is None:
            return None
        if self._store is None or self._of is not recording:
            self.close()
            # the tracker never sees the truth
            unaided = dataclasses.replace(recording, reference=None)
            self._store, self._of = CloudStore(unaided, reader), recording
        return self._store

    def close(self) -> None:
        """Forget all clouds; who uses them has ended."""
        if self._store is not None:
            self._store.close()
        self._store = self._of = None
