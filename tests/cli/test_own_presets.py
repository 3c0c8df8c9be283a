"""Presets of a person's own, given as files."""

import numpy as np

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.tracking.presets import UserPreset, preset, write_preset


def test_a_file_is_a_preset_to_track_with(run, recording, tmp_path):
    own = tmp_path / "own.toml"
    write_preset(own, UserPreset("few points", "fast", {"data_points": 300, "fit_shape": False}))
    words = ("--preset", "fast", "--set", "data_points=300", "--set", "fit_shape=no")
    for name, arguments in {"file": ("--preset", own), "words": words}.items():
        more = ("-o", tmp_path / f"{name}.npz", "--frames", "0:2", "--init", "tpose")
        run("track", recording, *arguments, *more)
    by_file, by_words = (read_run(tmp_path / f"{name}.npz") for name in ("file", "words"))
    np.testing.assert_array_equal(by_file.x, by_words.x)
    assert by_file.meta["preset"] == "few points", "a path says nothing to a reader"
    changed = preset("fast").replaced(data_points=300, fit_shape=False)
    assert by_file.meta["parameters"] == changed.values()
