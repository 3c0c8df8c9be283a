import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
RENDER = """
from dataclasses import replace
import numpy as np
from app.widgets.scene.content import Orbit
from app.widgets.scene.content import SceneContent
from app.widgets.scene.drawing import SceneRenderer, SceneUnavailable
from app.widgets.style.theme import load_theme
try:
    window = SceneRenderer()
    theme = replace(load_theme("dark"), scene_top="#ff0000", scene_bottom="#ff0000")
    window.set_content(SceneContent(), {"floor": False}, theme, 1.0)
    picture = window.picture(64, 48, Orbit(np.zeros(3), 0.0, 0.0, 2.0))
    print(picture.width(), picture.height(), picture.pixelColor(32, 24).name())
    window.close()
except SceneUnavailable as problem:
    print(problem)
"""


def rendered_with(before="", **environment):
    kept = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return subprocess.run(
        [sys.executable, "-c", before + RENDER],
        env=kept | {"PYTHONPATH": str(ROOT)} | environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


linux_only = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="about EGL and X")


@linux_only
@pytest.mark.parametrize("environment", [{}, {"DISPLAY": ":98765"}], ids=["none", "dead"])
def test_renders_without_a_display(environment):
    result = rendered_with(**environment)
    assert (result.returncode, result.stdout.strip()) == (0, "64 48 #ff0000"), result.stderr
    assert result.stderr == ""


@linux_only
def test_missing_opengl_is_a_sentence_and_no_crash():
    result = rendered_with(__EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent")
    assert result.returncode == 0, result.stderr
    assert "No OpenGL is available" in result.stdout
    assert result.stderr == ""
