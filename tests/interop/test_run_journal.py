"""Journals of runs: torn, damaged, foreign, and gone on with to the last bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.baselines import particles
from stereotrack_core.interop import run_journal
from stereotrack_core.interop.records import (
    Record,
    RecordFile,
    append_entry,
    read_journal,
    read_records,
)
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import RunJournal, Wish, has_frames, read_unfinished
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.same_run import same_run
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import pose_with_arms

FRAMES, MISSING = 7, 3
MAGIC = b"records1"
RECORDS = [
    Record("fact", {"a": 1.5, "b": 'ü \n "'}),
    Record(
        "numb", {}, {"x": np.arange(6.0).reshape(2, 3), "n": np.array([1, -2]), "e": np.zeros(0)}
    ),
    Record("turn", {"c": None}, {"P": np.asfortranarray(np.arange(6.0).reshape(2, 3))}),
]


def write_records(path, records):
    file = RecordFile(path, MAGIC)
    for record in records:
        file.append(record)
    file.close()
    return path.read_bytes()


def assert_records(found, wanted):
    found = list(found)
    assert [(one.kind, one.facts) for one in found] == [(one.kind, one.facts) for one in wanted]
    for one, other in zip(found, wanted, strict=True):
        assert one.arrays.keys() == other.arrays.keys()
        for name, array in one.arrays.items():
            np.testing.assert_array_equal(array, other.arrays[name])
            assert array.dtype == other.arrays[name].dtype
            assert array.flags.f_contiguous == other.arrays[name].flags.f_contiguous


def test_what_is_appended_is_read_again_and_can_be_gone_on_with(tmp_path):
    path = tmp_path / "a.part"
    write_records(path, RECORDS[:1])
    write_records(path, RECORDS[1:])
    assert_records(read_records(path, MAGIC), RECORDS)


@given(share=st.floats(0.0, 1.0))
def test_a_torn_record_is_lost_alone(tmp_path_factory, share):
    folder = tmp_path_factory.mktemp("records")
    lengths = [len(write_records(folder / f"{k}", RECORDS[:k])) for k in range(4)]
    path = folder / "3"
    kept = int(share * lengths[3])
    path.write_bytes(path.read_bytes()[:kept])
    left = RECORDS[: sum(kept >= length for length in lengths[1:])]
    assert_records(read_records(path, MAGIC), left)
    write_records(path, RECORDS[:1])
    assert_records(read_records(path, MAGIC), [*left, RECORDS[0]])


@given(place=st.integers(0, 10**6), value=st.integers(1, 255))
def test_a_byte_that_is_changed_gives_no_wrong_number(tmp_path_factory, place, value):
    path = tmp_path_factory.mktemp("records") / "a"
    data = bytearray(write_records(path, RECORDS))
    data[place % len(data)] ^= value
    path.write_bytes(data)
    if place % len(data) < len(MAGIC):
        with pytest.raises(ValueError, match="unknown file signature"):
            list(read_records(path, MAGIC))
        return
    found = list(read_records(path, MAGIC))
    known = [one for one in RECORDS if one.kind in {each.kind for each in found}]
    assert_records(found, known)


def test_one_program_at_a_time_writes(tmp_path):
    path = tmp_path / "run.npz.part"
    journal = RunJournal(path, lambda: 0.0)
    with pytest.raises(InputError, match="another program"):
        RunJournal(path, lambda: 0.0)
    journal.close()
    assert not path.exists(), "nothing was kept in it"
    with pytest.raises(InputError, match="cannot write"):
        RunJournal(tmp_path / "missing" / "run.part", lambda: 0.0)


@pytest.mark.parametrize("content", [b"", b"hello, world"])
def test_other_files_are_refused(content, tmp_path):
    path = tmp_path / "run.part"
    path.write_bytes(content)
    with pytest.raises(InputError, match="not an unfinished run"):
        read_run(path)
    assert has_frames(path) == bool(content)


LESS = {
    "accurate": {"data_points": 300, "search_proposals": 60},
    "thesis": {"model_points": 40},
    "annealed": {},
}


def settings(name):
    changes = {"data_points": 400, "search_arms": False} if name == "fast" else LESS[name]
    return preset(name).replaced(pixel_step=1, speckle_size=0, **changes)


@pytest.fixture(autouse=True, scope="module")
def few_layers():
    """Less work for the baseline, whose arms may be anywhere."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(particles, "LAYERS", 2)
        yield


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Somebody who is out of sight in one frame, so that others are on trial after it."""
    body = body_model(AVERAGE, settings("fast").body)
    poses = [
        pose_with_arms(
            [1, 0.12 * k, -0.05 * k],
            [1, 0.2 * k, 0],
            [-1, 0.1 * k, 0.06 * k],
            [-1, 0.2 * k, 0.1 * k],
            place=(0.02 * k, 0.0, 0.95),
        )
        for k in range(FRAMES)
    ]
    folder = tmp_path_factory.mktemp("recording") / "cones"
    return write_depth_recording(folder, body, poses, missing={MISSING})


@pytest.fixture(scope="module", params=["fast", "accurate", "thesis", "annealed"])
def tracked(request, recording, tmp_path_factory):
    """A run that is gone over backwards, and its journal after each of its frames."""
    path = tmp_path_factory.mktemp("journal") / "run.part"
    states = []
    journal = RunJournal(path, lambda: 7.0, Wish(smooth=True))
    patch = pytest.MonkeyPatch()
    patch.setattr(run_journal, "_FRAMES_PER_CHECKPOINT", 2)
    chosen = settings(request.param)

    def keep(advance):
        journal.keep(advance)
        states.append(path.read_bytes())

    spec = RunSpec(chosen, preset=request.param, init="tpose", smooth=True)
    run = track(recording, spec, on_advance=keep)
    journal.close()
    patch.undo()
    return request.param, chosen, run, states


@pytest.mark.parametrize("done", [1, MISSING + 2, FRAMES])
def test_a_run_that_goes_on_is_the_one_that_nobody_stopped(done, recording, tracked, tmp_path):
    name, chosen, whole, states = tracked
    path = tmp_path / "run.part"
    path.write_bytes(states[done - 1])
    begun, wish = read_unfinished(path)
    assert [frame.frame for frame in begun.frames] == list(range(done))
    assert wish.smooth
    assert begun.checkpoint.frame == (done - 1) // 2 * 2
    journal, changed = RunJournal(path, lambda: 9.0, wish), []

    def keep(advance):
        journal.keep(advance)
        changed.extend(map(begun.changed_by, advance.gained.frames))

    spec = RunSpec(chosen, preset=name, init="tpose", smooth=True)
    again = track(recording, spec, begun=begun, on_advance=keep)
    journal.close()
    assert same_run(whole, again)
    assert not any(changed)
    assert again.meta["resumed_at"] == ([begun.checkpoint.frame + 1] if done < FRAMES else [])
    kept, _ = read_unfinished(path)
    assert [frame.frame for frame in kept.frames] == list(range(FRAMES))
    assert kept.wall_seconds == (9.0 if done < FRAMES else 7.0)


ENTRIES = [{"job": "a", "value": 1.5}, {"job": "b", "words": 'ü \n " ]}'}, {"job": "c"}]


def written(path, entries):
    for entry in entries:
        append_entry(path, entry)
    return path.read_bytes()


def test_what_is_appended_is_read_again(tmp_path):
    path = tmp_path / "a.jsonl"
    assert read_journal(path) == []
    written(path, ENTRIES[:1])
    written(path, ENTRIES[1:])
    assert read_journal(path) == ENTRIES


@given(share=st.floats(0.0, 1.0))
def test_a_torn_line_is_lost_alone(tmp_path_factory, share):
    path = tmp_path_factory.mktemp("journal") / "a.jsonl"
    whole = written(path, ENTRIES)
    kept = int(share * len(whole))
    path.write_bytes(whole[:kept])
    left = read_journal(path)
    assert left == ENTRIES[: whole[:kept].count(b"\n")]
    written(path, [{"job": "d"}])
    assert read_journal(path) == [*left, {"job": "d"}] or (
        # the line's end alone was missing, so that the entry is complete after all
        read_journal(path) == [*ENTRIES[: len(left) + 1], {"job": "d"}]
    )
