"""Whether a recording really has colours: many store grey pictures as colour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.frames import FrameSet
from stereotrack_core.recording.reader import FrameReader

_EVERY = 4
"""Only every so many columns and rows are looked at."""

_DIFFERENCE = 8
"""Levels between the channels of a pixel from which it has a colour."""

_SHARE = 0.01
"""Share of such pixels from which a picture has colours."""


def has_colours(recording: Recording, views: Sequence[str]) -> bool:
    """Whether the reference pictures of any of these views have colours, by the first frame.

    Raises
    ------
    InputError
        When a stream cannot be opened.
    """
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        known, _ = reader.frame_count_so_far()
        return known > 0 and shows_colours(reader.frame_set(0))


def shows_colours(frame_set: FrameSet) -> bool:
    """Whether any of the frame set's reference pictures has colours."""
    for images in frame_set.views.values():
        picture = images.image
        if picture.ndim < 3:
            continue
        thin = picture[::_EVERY, ::_EVERY].astype(np.int16)
        spread = thin.max(axis=2) - thin.min(axis=2)
        if np.mean(spread >= _DIFFERENCE) > _SHARE:
            return True
    return False
