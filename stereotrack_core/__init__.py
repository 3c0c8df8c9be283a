"""Tracking of the articulated upper body on multi-view stereo recordings.

What a notebook imports stands here; each name is loaded when it is first used. The rooms are laid
out as the data flows: ``geometry``, ``recording``, ``depth``, ``body``, ``filtering``,
``tracking``, ``annotation``, ``evaluation``; ``study`` makes many runs, ``simulation`` makes
recordings, ``interop`` reads and writes foreign formats, ``project`` keeps what people made.
Nothing in here imports Qt.

Examples
--------
>>> from pathlib import Path
>>> import stereotrack_core as stereotrack
>>> recording = stereotrack.open_recording(Path("recording"))
>>> run = stereotrack.track(recording, stereotrack.RunSpec(stereotrack.preset("accurate")))
>>> stereotrack.evaluate(run, recording.reference).measure("forearms").statistics.mean
9.1
"""

import importlib
import os
from typing import TYPE_CHECKING, Any

from stereotrack_core.version import __version__ as __version__

if TYPE_CHECKING:
    from stereotrack_core.annotation.fit.fit import FitRequest as FitRequest
    from stereotrack_core.annotation.fit.fit import fit_reference as fit_reference
    from stereotrack_core.depth.chain import DepthChain as DepthChain
    from stereotrack_core.evaluation.failure_segments.find import failures as failures
    from stereotrack_core.evaluation.summary import evaluate as evaluate
    from stereotrack_core.interop.labels import read_clicks as read_clicks
    from stereotrack_core.interop.run_file import read_run as read_run
    from stereotrack_core.interop.run_file import write_run as write_run
    from stereotrack_core.project.project import Project as Project
    from stereotrack_core.recording.folder import open_recording as open_recording
    from stereotrack_core.simulation.make import Simulation as Simulation
    from stereotrack_core.simulation.make import simulate as simulate
    from stereotrack_core.tracking.presets import preset as preset
    from stereotrack_core.tracking.run import track as track
    from stereotrack_core.tracking.run_spec import RunSpec as RunSpec

# OpenCV reads these once, when it is loaded. A small file may unfold into any number of pixels, and
# what is wrong with a picture is told in our own words.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(1 << 27))
os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")

_HOMES = {
    "DepthChain": "depth.chain",
    "FitRequest": "annotation.fit.fit",
    "Project": "project.project",
    "RunSpec": "tracking.run_spec",
    "evaluate": "evaluation.summary",
    "failures": "evaluation.failure_segments.find",
    "fit_reference": "annotation.fit.fit",
    "open_recording": "recording.folder",
    "preset": "tracking.presets",
    "read_clicks": "interop.labels",
    "read_run": "interop.run_file",
    "Simulation": "simulation.make",
    "simulate": "simulation.make",
    "track": "tracking.run",
    "write_run": "interop.run_file",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    """Load a name of the public interface when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
