"""Tracking of the articulated upper body on multi-view stereo recordings.

The rooms are laid out as the data flows: ``geometry``, ``recording``, ``depth``, ``body``,
``filtering``, ``tracking``, ``evaluation``; ``simulation`` makes recordings, ``interop``
reads and writes foreign formats. Nothing in here imports Qt.
"""

__version__ = "0.1.0"
