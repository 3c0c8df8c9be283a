"""The thesis's own numbers, what is tracked for its tables, and tables from known errors."""

import dataclasses

import numpy as np
import pytest

from benchmarks.reproduce import FAST, SLOW, Column, Way, jobs, main, parts_of, tracked
from stereotrack_core.evaluation.summary import LimbErrors
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.motions import Part
from stereotrack_core.simulation.rig import SceneOptions

NAMES = ("P1", "P2", "P3", "P4")


def test_all_tables_have_their_runs():
    planned = jobs(NAMES, ("thesis", "accurate"), 2)
    assert len(set(planned)) == len(planned)
    assert [job[0] for job in planned[:8:2]] == [*NAMES]
    assert {str(way) for name, way, seed in planned if (name, seed) == ("P1", 1)} == {
        *("thesis", "thesis-restarted", "thesis-NS", "thesis-averaged"),
        *("thesis-m24", "thesis-m40", "thesis-m120"),
    }
    assert not any(name == "P3" and way.few_views for name, way, _ in planned)


def parts(degrees):
    angle = np.full(4, np.radians(degrees))
    both = np.stack([angle, angle], axis=1)
    errors = LimbErrors(np.arange(4), angle, angle, angle, both, both, np.ones(4, dtype=bool))
    return {SLOW: errors, FAST: errors, "whip": errors}


def test_frames_are_pooled_and_seeds_give_the_spread():
    way = Way("thesis")
    found = {(name, way, seed): parts(10.0 + 4 * seed) for name in NAMES for seed in (0, 1)}
    figure = Column(way, NAMES).figure(found, "forearms")
    assert figure.mean == pytest.approx(12.0)
    assert figure.deviation == pytest.approx(np.sqrt(8.0))
    del found["P4", way, 1]
    assert np.isnan(Column(way, NAMES).figure(found, "forearms").mean)


@pytest.mark.slow
def test_only_a_restarted_run_is_given_the_truth(tmp_path):
    options = SceneOptions(width=400, height=300, focal=250.0, furnished=False, noise=1.0)
    segments = (Part("t-pose", "t-pose", 0, 3), Part("point", "point", 4, 3))
    simulate(tmp_path / "P2", Simulation("P2", frames=7, options=options, parts=segments))
    recording = open_recording(tmp_path / "P2")
    wrong = dataclasses.replace(recording.reference, points=recording.reference.points + 0.5)
    misled = dataclasses.replace(recording, reference=wrong)
    for way, given in ((Way("thesis"), []), (Way("thesis", restarted=True), [0, 4])):
        runs = [tracked(one, way, 0) for one in (recording, misled)]
        assert runs[0].meta["started_at_reference"] == given
        same = np.array_equal(runs[0].landmarks, runs[1].landmarks, equal_nan=True)
        assert same == (not given)
    assert {*parts_of(recording, runs[0])} == {SLOW, FAST, "t-pose", "point"}


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_short_form_from_beginning_to_end(tmp_path, capsys):
    words = [str(tmp_path), "--short", "--seeds", "1", "--workers", "2"]
    main(words)
    text = (tmp_path / "tables.md").read_text("utf-8")
    assert all(f"## Table 4.{k}" in text for k in (1, 2, 3, 4))
    runs = {path: path.stat().st_mtime_ns for path in tmp_path.glob("runs/*/*.npz")}
    assert len(runs) == 38
    plain = tmp_path / "runs" / "P1" / "thesis-seed0.npz"
    landmarks = read_npz(plain).landmarks
    plain.unlink()
    main(words)
    assert [p for p, time in runs.items() if p.stat().st_mtime_ns != time] == [plain]
    assert np.array_equal(read_npz(plain).landmarks, landmarks, equal_nan=True)
    assert text in capsys.readouterr().out
