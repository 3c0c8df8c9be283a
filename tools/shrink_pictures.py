"""Makes pictures of the window small enough for a repository, by a palette of 256 colours.

``python tools/shrink_pictures.py PNG ...`` rewrites the files. The few pixels in strong colours,
such as the limbs', get a share of the palette of their own; else the many greys would take it all.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

WIDTH = 1400
GREYS, COLOURS = 144, 112
STRONG = 40  # spread of red, green and blue from which on a pixel counts as coloured


def shrunk(picture: Image.Image) -> Image.Image:
    """Return the picture, at most `WIDTH` pixels wide, with 256 colours."""
    plain = picture.convert("RGB")
    if plain.width > WIDTH:
        height = round(plain.height * WIDTH / plain.width)
        plain = plain.resize((WIDTH, height), Image.Resampling.LANCZOS)
    pixels = np.asarray(plain)
    strong = np.ptp(pixels.astype(np.int16), axis=2) > STRONG
    palette = [
        *_palette(pixels[~strong], GREYS, Image.Quantize.MEDIANCUT),
        *_palette(pixels[strong], COLOURS, Image.Quantize.FASTOCTREE),
    ]
    holder = Image.new("P", (1, 1))
    holder.putpalette(palette)
    return plain.quantize(palette=holder, dither=Image.Dither.NONE)


def _palette(pixels: NDArray[np.uint8], count: int, method: Image.Quantize) -> list[int]:
    if not len(pixels):
        return []
    found = Image.fromarray(pixels[np.newaxis]).quantize(count, method=method).getpalette()
    return (found or [])[: 3 * count]


def main(paths: Sequence[str]) -> int:
    """Shrink the files."""
    for path in map(Path, paths):
        with Image.open(path) as picture:
            result = shrunk(picture)
        result.save(path, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
