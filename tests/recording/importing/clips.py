"""Tiny videos and folders of images, with what the importer is to find in them."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import VideoWriter, write_png

WIDTH, HEIGHT, FRAMES = 64, 48, 12


def numbered(k: int, width: int = WIDTH) -> np.ndarray:
    """Picture that is brighter with every frame, its left half darker than its right half."""
    picture = np.full((HEIGHT, width), 40 + 8 * k, np.uint8)
    picture[:, width // 2 :] += 60
    return picture


def clip(
    path: Path,
    picture: Callable[[int], np.ndarray] = numbered,
    *,
    frames: int = FRAMES,
    fps: float = 25.0,
) -> Path:
    """A grey video whose frame k is ``picture(k)``."""
    path.parent.mkdir(parents=True, exist_ok=True)
    height, width = picture(0).shape
    with VideoWriter(path, fps=fps, width=width, height=height, crf=0) as video:
        for k in range(frames):
            video.write(picture(k))
    return path


def images(folder: Path, names: Callable[[int], str] = "{:04d}.png".format, depth: bool = False):
    """A folder of images; depth counts in millimetres, nearer with every frame."""
    folder.mkdir(parents=True)
    for k in range(FRAMES):
        picture = np.full((HEIGHT, WIDTH), 3000 - 10 * k, np.uint16) if depth else numbered(k)
        if depth:
            picture[:, :8] = 0
            picture[:, -8:] = 1500
        write_png(folder / names(k), picture)
    return folder


def flashing(at):
    """Dark frames; the light is switched on within frame `at`, for a fraction of its exposure."""

    def picture(k):
        share = float(np.clip(k + 1 - at, 0.0, 1.0))
        return np.full((HEIGHT, WIDTH), round(40 + 120 * share), np.uint8)

    return picture


def chosen(*paths: Path, **changes):
    """What is proposed for files, with changes."""
    return replace(propose(look_at(paths)), **changes)


def frames_of(recording) -> list:
    """The images of all frames by view."""
    with FrameReader(recording, colour=False, read_ahead=0) as reader:
        return [reader.frame_set(k).views for k in range(reader.frame_count)]
