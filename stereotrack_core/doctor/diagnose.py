"""Everything that the images and depths say about a recording: pictures, pairs, clocks, views.

What an earlier check has found wrong is left out of the later ones: a pair that cannot be matched
has no depth, and a view that is late would seem to stand elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from stereotrack_core.doctor.clocks import check_clocks
from stereotrack_core.doctor.clouds import check_clouds
from stereotrack_core.doctor.pairs import check_pairs
from stereotrack_core.doctor.pictures import check_pictures
from stereotrack_core.doctor.views import check_views
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

_VIEW = re.compile(r"^view (.+?)(?:, (?:left|right|background))?$")
_CACHE_BYTES = 128 * 1024 * 1024


def diagnose(recording: Recording) -> tuple[Finding, ...]:
    """Findings by measuring a recording; none where its cameras are guessed.

    Reads up to 600 frames and measures depth in some of them. Raises InputError where a stream
    cannot be opened.
    """
    if recording.guessed:
        return ()
    with FrameReader(recording, colour=False, cache_bytes=_CACHE_BYTES) as reader:
        if not reader.frame_count:
            return ()
        found = [*check_pictures(recording, reader), *check_pairs(recording, reader)]
        found += check_clocks(recording, reader)
        found += check_views(recording, reader, _views_of(found))
        found += check_clouds(recording, reader, _views_of(found))
    return tuple(found)


def _views_of(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Names of the views that findings blame."""
    matches = (_VIEW.match(one.where) for one in findings)
    return tuple(match[1] for match in matches if match)
