"""Whatever ends ``track``: what was there stays, every frame is kept, and it goes on."""

import os
import shlex
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from stereotrack_core.interop.run_file import read_run, write_run
from tests.conftest import FAST
from tests.end_to_end.conftest import DENSE, FRAMES, Ended
from tests.end_to_end.damage import substitute
from tests.same_run import same_run

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="there are no such signals")

PROGRAM = Path(__file__).with_name("held_tracking.py")
ROOT = PROGRAM.parents[2]
HELD = 5
ENDS = [
    signal.SIGKILL,
    "full drive",
    *(pytest.param(how, marks=pytest.mark.slow) for how in (signal.SIGINT, signal.SIGHUP)),
]
"""SIGTERM is sent by a test of its own."""


def stopped_by(how: signal.Signals | str, *words: object) -> Ended:
    """Track in a process that is ended when it has done some frames."""
    full = ["limit"] if how == "full drive" else []
    process = subprocess.Popen(
        [sys.executable, str(PROGRAM), *full, str(HELD), "track", *map(str, words)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    if isinstance(how, signal.Signals):
        assert process.stdout.readline() == "held\n", process.communicate()[1]
        process.send_signal(how)
    out, err = process.communicate("\n")
    assert "Traceback" not in err
    return Ended(process.returncode, out, err)


@pytest.fixture(scope="module")
def older(whole, tmp_path_factory):
    """An output at which a complete older run stands."""
    run, place = read_run(whole), tmp_path_factory.mktemp("older") / "run.npz"
    write_run(place, replace(run, landmarks=run.landmarks + 0.01, x=run.x + 0.01))
    return place


@pytest.fixture(scope="module")
def killed(sound, older):
    """How a run ended that was killed, and what is left of it beside the older run."""
    ended = stopped_by(signal.SIGKILL, sound, "-o", older, *FAST)
    return ended, part_of(older).read_bytes()


@pytest.fixture
def place(older, tmp_path):
    """The output in a folder of its own."""
    return Path(shutil.copy(older, tmp_path))


@pytest.fixture
def left(killed, place):
    """What the killed run has left there."""
    part_of(place).write_bytes(killed[1])
    return part_of(place)


def part_of(place):
    return place.with_name(f"{place.name}.part")


@pytest.mark.parametrize("how", ENDS)
def test_nothing_is_lost_whatever_ends_it(how, sound, whole, older, killed, place, run):
    part = part_of(place)
    if how == signal.SIGKILL:
        ended, content = killed
        part.write_bytes(content)
    else:
        ended = stopped_by(how, sound, "-o", place, *FAST)
    assert place.read_bytes() == older.read_bytes()
    left = read_run(part)
    assert left.frame.tolist() == list(range(HELD))
    assert left.meta["incomplete"]
    again = shlex.join(["stereotrack", "track", str(sound), "-o", str(place), "--resume"])
    if how == signal.SIGKILL:
        assert ended.status == -signal.SIGKILL
    else:
        assert ended.status == 1
        assert str(part) in ended.err
        assert again in ended.err
    told = run("evaluate", part, "--frames", f"0:{HELD}")
    assert told.status == 0
    assert f"{HELD} of {FRAMES} frames" in told.err
    gone_on = run("track", sound, "-o", place, "--resume", "--json")
    assert gone_on.status == 0
    assert gone_on.json["changed"] == []
    assert not part.exists()
    assert same_run(read_run(whole), read_run(place))
    assert read_run(place).meta["resumed_at"] == gone_on.json["resumed_at"] == [1]


def test_without_an_older_run_the_frames_are_written_too(sound, whole, tmp_path, run):
    place = tmp_path / "run.npz"
    ended = stopped_by(signal.SIGTERM, sound, "-o", place, *FAST)
    assert ended.status == 1
    assert f"Stopped after {HELD} of {FRAMES} frames; they are in {place}." in ended.err
    assert read_run(place).frame.tolist() == read_run(part_of(place)).frame.tolist()
    refused = run("track", sound, "-o", place, *FAST)
    assert "--resume" in refused.sentence
    assert str(part_of(place)) in refused.sentence
    assert read_run(place).frame.tolist() == list(range(HELD))
    assert run("track", sound, "-o", place, "--resume").status == 0
    assert same_run(read_run(whole), read_run(place))


@pytest.mark.parametrize(
    "preset",
    ["fast", *(pytest.param(name, marks=pytest.mark.slow) for name in ("accurate", "thesis"))],
)
def test_a_background_that_is_learned_on_the_way_goes_on_too(preset, copy, tmp_path, run):
    substitute(copy / "recording.toml", r"(?m)^background = .*\n", "")
    words = (copy, *FAST, *DENSE, "--preset", preset, "--frames", "0:6")
    words += ("--set", "search_proposals=60", "--set", "data_points=300")
    words += ("--set", "outlier_neighbours=0")  # tiny pictures give sparse points
    place = tmp_path / "run.npz"
    stopped_by(signal.SIGKILL, *words, "-o", place, "--smooth")
    assert run("track", copy, "-o", place, "--resume").status == 0
    alone = tmp_path / "alone.npz"
    assert run("track", *words, "-o", alone, "--smooth").status == 0
    assert same_run(read_run(alone), read_run(place))
    assert read_run(place).meta["smoothed"]


@pytest.mark.parametrize(
    ("option", "word"),
    [
        (("--seed", 3), "--seed"),
        (("--set", "iterations=1"), "--set"),
        (("--views", "N"), "--views"),
    ],
)
def test_it_goes_on_as_it_was_begun_or_not_at_all(option, word, sound, place, left, run):
    kept, before = left.read_bytes(), place.read_bytes()
    refused = run("track", sound, "-o", place, "--resume", *option)
    assert f"{word}: an unfinished run is resumed with the settings" in refused.sentence
    assert (left.read_bytes(), place.read_bytes()) == (kept, before)


def test_another_recording_is_refused(copy, place, left, run):
    kept = left.read_bytes()
    text = (copy / "calibration.toml").read_text()
    (copy / "calibration.toml").write_text(text.replace("200.0", "201.0", 1))
    assert "recording" in run("track", copy, "-o", place, "--resume").sentence
    assert left.read_bytes() == kept


def test_there_has_to_be_something_to_go_on_with(sound, place, run):
    assert "no unfinished run" in run("track", sound, "-o", place, "--resume").sentence
    part_of(place).write_bytes(b"strun 1\n")  # killed before the first frame
    assert "no unfinished run" in run("track", sound, "-o", place, "--resume").sentence
    part_of(place).write_bytes(b"hello, world")
    assert "not an unfinished run" in run("track", sound, "-o", place, "--resume").sentence
    assert "Resume it with --resume" in run("track", sound, "-o", place, *FAST).sentence
    assert part_of(place).read_bytes() == b"hello, world"
