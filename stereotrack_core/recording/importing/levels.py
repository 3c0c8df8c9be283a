"""Pictures of more than 8 bits as 8: which value becomes white.

One value for the whole recording, so that brightness means the same in every picture and in both
images of a stereo camera. It is the largest value of the sensor (255, 1023, 4095, 16383 or 65535):
as the files state it, else the smallest that the pictures stay below.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stereotrack_core.reading import open_file
from stereotrack_core.recording.images import (
    MEASURED_PICTURES,
    WHITEST,
    DamagedFrame,
    white_of,
)
from stereotrack_core.recording.importing.readers import open_stored
from stereotrack_core.recording.importing.source import Source

if TYPE_CHECKING:
    from stereotrack_core.recording.importing.choices import Choices, Use

_MAX_SAMPLE_VALUE = 281  # TIFF's tag
_PNG_HEADER_BYTES = 1024


def measured(source: Source) -> Source:
    """The source with its white and how much of it is saturated; as it is if it has 8 bits.

    Raises InputError where it cannot be opened.
    """
    if source.bits <= 8 or source.unit is not None or source.white:
        return source
    reader = open_stored(source)
    counts = np.zeros(WHITEST + 1, dtype=np.int64)
    try:
        for k in np.unique(np.linspace(0, reader.count() - 1, MEASURED_PICTURES).astype(int)):
            with suppress(DamagedFrame):  # said when it is written
                picture = reader.read(int(k), lambda _number, _picture: None)
                counts += np.bincount(picture.ravel(), minlength=WHITEST + 1)
    finally:
        reader.close()
    white = white_of(counts, _stated(source.path) if source.images else None)
    saturated = float(counts[white:].sum() / max(int(counts.sum()), 1))
    return replace(source, white=white, saturated=saturated)


def _stated(path: Path) -> int | None:
    """The largest value that a TIFF or PNG states for its pictures of 16 bits."""
    from PIL import Image, UnidentifiedImageError

    with suppress(OSError, UnidentifiedImageError, ValueError, Image.DecompressionBombError):
        with open_file(path) as file:
            header = file.read(_PNG_HEADER_BYTES).partition(b"IDAT")[0]
        if header.startswith(b"\x89PNG"):
            bits = header.partition(b"sBIT")[2][:1]
            return 2 ** bits[0] - 1 if bits and 8 <= bits[0] <= 16 else None
        with Image.open(path) as image:
            value = getattr(image, "tag_v2", {}).get(_MAX_SAMPLE_VALUE)
        largest = max(value) if isinstance(value, tuple) else value
        return int(largest) if largest and 255 <= largest < WHITEST else None
    return None


def with_one_white(choices: Choices) -> Choices:
    """Choices whose pictures of more than 8 bits have one white, by default the largest measured.

    Images of depth cameras, which are infrared, have one of their own. Raises InputError where a
    source cannot be opened.
    """
    uses = [
        replace(use, source=measured(use.source)) if shows_brightness(use) else use
        for use in choices.uses
    ]
    return replace(choices, uses=tuple(_of_its_group(use, uses) for use in uses))


def shows_brightness(use: Use) -> bool:
    """Whether a source of more than 8 bits is written again with 8."""
    return use.source.bits > 8 and use.role not in ("depth", "unused")


def _of_its_group(use: Use, uses: Sequence[Use]) -> Use:
    if not shows_brightness(use):
        return use
    infrared = use.role == "image"
    group = [one for one in uses if shows_brightness(one) and (one.role == "image") == infrared]
    return replace(use, source=replace(use.source, white=max(one.source.white for one in group)))
