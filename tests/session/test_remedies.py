"""Remedies of a failure: tried, ranked, checked where the run was good, stopped, used."""

import shutil
from dataclasses import replace
from multiprocessing import active_children
from pathlib import Path

import pytest

from app.session import remedies
from app.session.runs import entry_of_run
from stereotrack_core.atomic import make_folder
from stereotrack_core.evaluation.failure_segments import find
from stereotrack_core.interop.run_npz import write_npz
from stereotrack_core.parameters import value_text
from stereotrack_core.study.description import Study, StudySettings, with_recordings, write_study
from stereotrack_core.study.run import plan_study
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tuning.remedy import Change
from tests.gui.made_runs import made_run

QUICK = {
    "fit_shape": False, "detector": "off", "search_proposals": 30, "search_refined": 1,
    "data_points": 300, "pixel_step": 1, "speckle_size": 0, "max_unexplained_fraction": 1.0,
}  # fmt: skip
SETTINGS = preset("fast").replaced(**QUICK)


@pytest.fixture
def failing(shown, small_recording):
    """A session whose active run has lost the arms in frames 1 to 3."""
    session = shown.session
    session.open(small_recording)
    shown.until(lambda: session.project.project is not None and session.settled())
    run = made_run(session.document.recording, off=0.05, wild=(1, 2, 3))
    entry = entry_of_run(run, Path("wild.npz"))
    entry.settings = SETTINGS
    session.runs.add(entry)
    shown.until(lambda: session.settled() and bool(session.failures.listed))
    session.failures.choose(next(e for e in session.failures.listed if e.found == "truth"))
    return session


def changed(_settings, names):
    assert "search_proposals" in names
    other = SETTINGS.replaced(arms_apart=0.0)
    return Change("more candidates", SETTINGS.replaced(search_proposals=40)), Change("no", other)


def test_changes_are_ranked_and_the_best_checked_on_good_frames(shown, failing, monkeypatch):
    monkeypatch.setattr(remedies, "changes", changed)
    monkeypatch.setattr(remedies, "_GOOD_SECONDS", 0.1)
    monkeypatch.setattr(find, "_APART", 0.1)
    before = failing.runs.entries
    failing.remedies.find("remedy")
    shown.until(failing.settled)
    tried = failing.remedies.tried
    assert [one.gain for one in tried.remedies] == sorted(o.gain for o in tried.remedies)[::-1]
    assert len(tried.remedies) == tried.count == 3
    assert "no change" in [one.change.words for one in tried.remedies]
    assert (tried.good, failing.runs.entries) == (3, before)
    best = tried.remedies[0]
    unchanged = next(one for one in tried.remedies if one.change.words == "no change")
    assert unchanged.gain == pytest.approx(tried.error - unchanged.error)
    others = [one for one in tried.remedies if one is not unchanged]
    gains = [unchanged.error - one.error for one in others]
    assert [one.gain for one in others] == pytest.approx(gains), "all begin alike"
    assert best.gain > 10.0, "the tracker itself does not lose the arms of a T pose"
    assert best.harm is not None
    assert sorted(best.entry.frames) == list(tried.stretch)
    assert "No study is open" in failing.remedies.words()
    assert best.change.words in failing.remedies.words() or not remedies.is_harmless(best)

    failing.remedies.show(best)
    assert failing.runs.front is best.entry
    assert best.entry.kind == "trial"
    failing.remedies.use(best)
    assert failing.track.settings == best.change.settings


def test_the_run_and_the_changes_are_compared_over_the_same_frames(shown, failing):
    """A run that ends with the failure is not asked about the frames behind it."""
    run = made_run(failing.document.recording, off=0.05, wild=(1, 2, 3), frames=slice(0, 4))
    entry = entry_of_run(run, Path("short.npz"))
    entry.settings = SETTINGS
    failing.runs.add(entry)
    shown.until(lambda: failing.settled() and failing.runs.active is entry)
    failing.failures.choose(next(e for e in failing.failures.listed if e.found == "truth"))
    failing.remedies.find("remedy")
    assert failing.remedies.tried.stretch == range(4)
    failing.remedies.stop()
    shown.until(failing.settled)


def test_it_is_stopped_at_any_time_and_what_was_tried_stays(shown, failing):
    failing.remedies.find("parts")
    shown.until(lambda: bool(failing.remedies.tried.remedies))
    failing.remedies.stop()
    shown.until(failing.settled)
    assert 0 < len(failing.remedies.tried.remedies) < failing.remedies.tried.count
    known = failing.remedies.tried
    failing.runs.add(entry_of_run(known.run.run(), Path("next.npz")))
    assert failing.remedies.tried is known, "the next run is made by what was tried"
    assert "run “wild” has" in failing.remedies.words()
    views = [one for one in failing.remedies.tried.remedies if one.change.views]
    assert all(len(one.change.views) == 1 for one in views)
    assert shown.messages == [], "to be stopped is no error"


def test_reasons_of_failures_are_found_and_counted(shown, failing):
    assert failing.failures.why_no_reasons() == ""
    failing.failures.find_reasons()
    shown.until(failing.settled)
    found = [e for e in failing.failures.listed if e.reason is not None]
    assert found, "the step in which the failure begins was recorded with the true arms"
    assert found[0].parameters[: len(found[0].reason.parameters)] == found[0].reason.parameters


def test_without_a_failure_or_settings_it_is_said_why_not(shown, failing):
    failing.failures.choose(None)
    failing.document.go_to(7)
    assert "Select a failure" in failing.remedies.why_not()
    failing.remedies.find("remedy")
    assert failing.remedies.tried is None
    active = failing.runs.active
    active.settings = None
    assert "does not state" in failing.remedies.why_not()
    active.settings = replace(SETTINGS)


def children():
    """Processes that this one has started."""
    return {one.pid for one in active_children()}


@pytest.fixture
def studied(shown, failing, small_recording, tmp_path, monkeypatch):
    """The same, with an open study of it and of four copies; two have no video or no run."""
    for name in ("judged", "spoilt", "unjudged", "untracked"):
        shutil.copytree(small_recording, tmp_path / name)
    described = tmp_path / "unjudged" / "recording.toml"
    described.write_text(described.read_text().replace('reference = "reference.csv"', ""))
    changes = tuple(f"{name}={value_text(value)}" for name, value in QUICK.items())
    bare = Study(
        tmp_path / "walks.study.toml", settings=StudySettings(preset="fast", changes=changes)
    )
    study = with_recordings(bare, [small_recording, tmp_path]).study
    write_study(study)
    for job in plan_study(study, study.rows).jobs:
        if job.recording in {"judged", "unjudged"}:
            run = made_run(failing.document.recording, off=0.05)
            made = {"job": job.tracking, "parameters": SETTINGS.values(), "frames": [0, 8]}
            make_folder(Path(job.keep).parent)
            write_npz(Path(job.keep), replace(run, meta={**run.meta, **made}))
    (tmp_path / "spoilt" / "N_left.mp4").unlink()
    failing.study.open(study.path)
    shown.until(lambda: failing.settled() and not failing.study.working)
    one, none = SETTINGS.replaced(iterations=1), SETTINGS.replaced(search_arms=False)
    asked = Change("hasty", one), Change("no search", none)
    monkeypatch.setattr(remedies, "changes", lambda *_: asked)
    monkeypatch.setattr(remedies, "_GOOD_SECONDS", 0.1)
    monkeypatch.setattr(find, "_APART", 0.1)
    return failing


def test_the_best_are_checked_on_the_other_recordings_of_the_study(shown, studied):
    before = children()
    studied.remedies.find("remedy")
    assert "0 of 4 other recordings" in studied.remedies.words(), "it is said from the beginning"
    shown.until(studied.settled)
    tried = studied.remedies.tried
    assert [row.recording for row in tried.others] == ["judged", "spoilt", "unjudged", "untracked"]
    found = {one.change.words: one for one in tried.remedies}
    hasty, still = found["hasty"], found["no search"]
    units = [("judged", "°"), ("unjudged", " %")]
    assert [(one.recording, one.unit) for one in hasty.elsewhere] == units
    assert hasty.worst_elsewhere.recording == "judged"
    assert hasty.worst_elsewhere.worst == pytest.approx(hasty.harm), "a copy of the recording"
    assert not remedies.is_harmless(hasty)
    assert remedies.is_harmless(still)
    assert not remedies.is_harmless(replace(still, elsewhere=hasty.elsewhere))
    assert [name for name, _ in tried.left_out] == ["spoilt", "untracked"]
    words = studied.remedies.words()
    assert "Best without harm: no search. Study walks: 2 of 4 other recordings checked" in words
    assert "but not spoilt (file 'N_left.mp4' not found), untracked (no run is kept)." in words
    assert shown.messages == [], "that a recording is left out is no error"
    assert children() - before <= {studied.processes.trials.pid}, "that of the others has ended"


def test_it_is_stopped_while_others_are_checked_and_their_process_ends(shown, studied):
    before = children()
    studied.remedies.find("remedy")
    shown.until(lambda: any(one.elsewhere for one in studied.remedies.tried.remedies))
    studied.remedies.stop()
    shown.until(studied.settled)
    checked = [one for one in studied.remedies.tried.remedies if one.elsewhere]
    assert {one.elsewhere[0].recording for one in checked} == {"judged"}
    assert children() - before <= {studied.processes.trials.pid}
    assert shown.messages == []
