"""Every warning of Qt fails a test here; without a display Qt paints into memory."""

import os
from pathlib import Path

import pytest

if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

_HERE = Path(__file__).parent


def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.is_relative_to(_HERE):
            item.add_marker(pytest.mark.qt_log_level_fail("WARNING"))
            # said by the platform that paints into memory for every window
            item.add_marker(pytest.mark.qt_log_ignore("plugin does not support"))
