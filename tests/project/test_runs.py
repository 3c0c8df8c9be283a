"""Runs are kept complete, listed without being read, renamed, removed and restored."""

from dataclasses import fields, replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_npz import run_bytes
from stereotrack_core.project import entries, runs
from stereotrack_core.project.clicks import move_clicks, place
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.entries import facts_as_json, save_entry
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import RUN
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset

CLICK = Click(1, "N", "head", (1.0, 2.0))


def meta(**changes):
    made_with = preset("fast").replaced(**changes)
    return {
        "version": "1", "preset": "fast", "parameters": made_with.values(), "seed": 3,
        "views": ["N", "S"], "init": "auto", "smoothed": False, "frames": [0, 40],
        "recording": "walk", "subject": {"name": "P2"}, "fingerprint": "ab" * 16,
        "calibration": "cd" * 16, "versions": {"stereotrack": "1", "numpy": "2.1"},
        "wall_seconds": 1.5, "made": "2026-01-02T03:04:05.000+00:00",
    }  # fmt: skip


def run(frames: int = 3, seed: int = 2, n: int = 4, **changes) -> Run:
    rng = np.random.default_rng(seed)
    landmarks = rng.normal(size=(frames, 9, 3))
    landmarks[-1] = np.nan
    return Run(
        frame=np.arange(frames),
        landmarks=landmarks,
        x=rng.normal(size=(frames, n)),
        P=rng.normal(size=(frames, n, n)),
        state_names=tuple(f"state {k}" for k in range(n)),
        tracked=np.arange(frames) < frames - 1,
        unexplained_fraction=rng.random(frames),
        residual=rng.random(frames),
        innovation=rng.random(frames),
        limb_sigma_deg=rng.random((frames, 6)),
        limb_lost=rng.random((frames, 6)),
        seconds=rng.random((frames, 2)),
        stage_names=("depth", "tracking"),
        meta=meta(**changes),
    )


def assert_same(found: Run, kept: Run) -> None:
    for field in fields(Run):
        a, b = getattr(found, field.name), getattr(kept, field.name)
        if isinstance(b, np.ndarray):
            assert (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes()), field.name
        else:
            assert a == b, field.name


def test_a_run_comes_back_bit_by_bit_after_the_project_was_closed(project, project_path):
    project.apply(runs.keep_run("accurate", run()))
    project.close()
    with Project.open(project_path) as again:
        assert_same(runs.load_run(again.runs, "accurate"), run())


def test_the_list_says_what_a_run_was_made_with_and_reads_no_numbers(project, monkeypatch):
    project.apply(runs.keep_run("one", run(iterations=2, data_points=401)))
    monkeypatch.setattr(entries, "fetch", lambda *_: pytest.fail("numbers were read"))
    (kept,) = runs.kept_runs(project.runs)
    assert (kept.name, kept.who) == ("one", "A")
    facts = kept.facts
    assert facts.changed == {"iterations": (3, 2), "data_points": (800, 401)}
    assert set(facts.changed_words.split(", ")) == {
        "iterations 2 instead of 3",
        "data_points 401 instead of 800",
    }
    assert (facts.frames, facts.tracked, facts.first, facts.last) == (3, 2, 0, 2)
    assert (facts.preset, facts.seed, facts.views, facts.init) == ("fast", 3, ("N", "S"), "auto")
    assert (facts.wall_seconds, facts.made[:4]) == (1.5, "2026")
    assert not facts.smoothed


def test_runs_of_one_name_are_not_mixed_up(project):
    project.apply(runs.keep_run("accurate", run()))
    with pytest.raises(InputError, match="already"):
        project.apply(runs.keep_run("accurate", run(seed=9)))
    other = runs.free_name(project.runs, "accurate")
    assert other == "accurate (2)"
    project.apply(runs.keep_run(other, run(seed=9)))
    assert_same(runs.load_run(project.runs, "accurate"), run())
    assert_same(runs.load_run(project.runs, other), run(seed=9))
    a, b = runs.kept_runs(project.runs)
    assert a.content != b.content
    project.apply(runs.delete_run("accurate"))
    assert runs.free_name(project.runs, "accurate") == "accurate (3)"


def test_a_run_is_removed_and_restored(project):
    project.apply(runs.keep_run("accurate", run()))
    changed = project.apply(runs.delete_run("accurate"))
    assert changed.words == "delete run accurate"
    assert (runs.kept_runs(project.runs), runs.removed_runs(project.runs)) == ((), ("accurate",))
    with pytest.raises(InputError, match="no run 'accurate'"):
        runs.load_run(project.runs, "accurate")
    project.apply(runs.restore_run("accurate"))
    assert_same(runs.load_run(project.runs, "accurate"), run())
    assert runs.removed_runs(project.runs) == ()
    with pytest.raises(InputError, match="was removed"):
        project.apply(runs.restore_run("accurate"))


def test_runs_are_nothing_that_undo_and_redo_know_of(project):
    step = move_clicks((CLICK.key,), (0.5, 0.0))
    project.apply(place(CLICK))
    project.apply(step, continues=True)
    project.apply(runs.keep_run("accurate", run()))
    project.apply(step, continues=True)
    assert project.clicks.at(1)[0].position == (2.0, 2.0), "small steps around it stay one edit"
    project.undo()
    project.apply(runs.rename_run("accurate", "better"))
    project.apply(runs.delete_run("better"))
    assert project.clicks.at(1)[0].position == (1.0, 2.0)
    assert [entry.state for entry in project.history.entries()] == ["undone", "done"]
    project.redo()


def test_a_run_is_renamed_with_all_that_belongs_to_it(project):
    project.apply(runs.keep_run("first", run()))
    (before,) = runs.kept_runs(project.runs)
    assert project.apply(runs.rename_run("first", "better")).words == "rename run first to better"
    (after,) = runs.kept_runs(project.runs)
    assert after == replace(before, name="better")
    assert_same(runs.load_run(project.runs, "better"), run())
    assert project.apply(runs.rename_run("better", "better")) is None


def test_a_name_that_is_taken_empty_or_unknown_is_refused(project):
    project.apply(runs.keep_run("one", run()))
    project.apply(runs.keep_run("two", run(seed=9)))
    for wrong, words in (
        (("one", "two"), "already"),
        (("one", " "), "no name"),
        (("x", "y"), "no run"),
    ):
        with pytest.raises(InputError, match=words):
            project.apply(runs.rename_run(*wrong))
    project.apply(runs.delete_run("two"))
    project.apply(runs.rename_run("one", "two"))
    assert_same(runs.load_run(project.runs, "two"), run())


def test_data_that_have_changed_are_never_given_out(project):
    project.apply(runs.keep_run("accurate", run()))
    with project._access.writing() as database:
        database.execute("UPDATE content SET bytes = X'00'")
    with pytest.raises(ProjectDamaged):
        runs.load_run(project.runs, "accurate")


def test_few_facts_are_read_and_senseless_ones_are_damage(project):
    few = {"frames": 7, "tracked": 6, "preset": "accurate", "seed": 1}
    project.apply(save_entry(RUN, "few", facts_as_json(few), run_bytes(run())))
    facts = runs.kept_runs(project.runs)[0].facts
    assert (facts.frames, facts.changed) == (7, {})
    project.apply(save_entry(RUN, "odd", facts_as_json({"frames": "many"}), run_bytes(run())))
    with pytest.raises(ProjectDamaged):
        runs.kept_runs(project.runs)
