"""Tracking of the articulated upper body on multi-view stereo recordings.

The rooms are laid out as the data flows: ``geometry``, ``recording``, ``depth``, ``body``,
``filtering``, ``tracking``, ``evaluation``; ``simulation`` makes recordings, ``interop``
reads and writes foreign formats. Nothing in here imports Qt.
"""

import os

__version__ = "0.1.0"

# OpenCV reads these once, when it is loaded. A small file may unfold into any number of pixels, and
# what is wrong with a picture is told in our own words.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(1 << 27))
os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
