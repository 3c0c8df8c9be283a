"""``stereotrack compare`` says what frames show, with a reference and without."""

import shutil

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run, write_run

pytestmark = pytest.mark.xdist_group("cli")


def lengthened(run, sigma, frames=160):
    """A run of many frames whose landmarks are the reference's with errors."""
    from dataclasses import replace

    times = -(-frames // len(run.frame))
    rng = np.random.default_rng(round(1000 * sigma))
    arrays = {
        name: np.concatenate([getattr(run, name)] * times)[:frames]
        for name in (
            *("landmarks", "x", "P", "tracked", "unexplained_fraction", "residual", "innovation"),
            *("limb_sigma_deg", "limb_lost", "seconds"),
        )
    }
    arrays["landmarks"] = np.tile(run.landmarks[run.tracked][0], (frames, 1, 1))
    arrays["landmarks"] += sigma * rng.normal(size=arrays["landmarks"].shape)
    return replace(run, frame=np.arange(frames), **arrays)


@pytest.fixture(scope="module")
def runs(tracked, tmp_path_factory):
    """Two runs of many frames, the second with half the errors, and what is true."""
    folder = tmp_path_factory.mktemp("compare")
    stored = read_run(tracked)
    for name, sigma in (("rough", 0.04), ("fine", 0.02), ("truth", 0.0)):
        write_run(folder / f"{name}.npz", lengthened(stored, sigma))
    write_run(folder / "truth.csv", read_run(folder / "truth.npz"))
    return folder


def test_the_better_run_is_named_in_a_sentence(run, runs):
    ended = run("compare", runs / "rough.npz", runs / "fine.npz", "--reference", runs / "truth.csv")
    assert ended.status == 0
    assert "B is better by" in ended.out
    assert "160 frames" in ended.out
    facts = run(
        "compare", runs / "rough.npz", runs / "fine.npz", "--reference", runs / "truth.csv",
        "--json", "--frames", "20:",
    ).json  # fmt: skip
    forearms = facts["pairs"][0]["measures"]["forearms"]
    assert facts["frames"] == 140
    assert forearms["low"] < forearms["difference"] < forearms["high"] < 0
    assert forearms["differs"]
    evaluated = run("evaluate", runs / "fine.npz", "--reference", runs / "truth.csv", "--json",
                    "--frames", "20:").json  # fmt: skip
    assert forearms["second_mean"] == pytest.approx(evaluated["measures"]["forearms"]["mean"])
    lost = facts["pairs"][0]["measures"]["lost"]["second_mean"]
    assert lost == pytest.approx(evaluated["lost_percent"])


def test_without_a_reference_agreement_is_told(run, runs, recording):
    assert (recording / "reference.csv").is_file()
    bare = runs / "bare"
    bare.mkdir()
    for name in ("rough", "fine"):
        write_run(bare / f"{name}.csv", read_run(runs / f"{name}.npz"))
    ended = run("compare", bare / "rough.csv", bare / "fine.csv")
    assert ended.status == 0
    assert "No reference" in ended.out
    assert "distance from each other" in ended.out
    assert "No reference" in ended.err


def test_the_recordings_own_reference_and_segments_are_used(run, recording, tracked, tmp_path):
    moved = tmp_path / "tiny"
    shutil.copytree(recording, moved)
    description = (moved / "recording.toml").read_text()
    if "segments" not in description:
        (moved / "recording.toml").write_text(f'segments = "segments.csv"\n{description}')
    (moved / "segments.csv").write_text("segment,first,end\nstart,0,4\nrest,4,10\n")
    from dataclasses import replace

    stored = read_run(tracked)
    here = replace(stored, meta={**stored.meta, "recording_folder": str(moved)})
    write_run(tmp_path / "a.npz", here)
    write_run(tmp_path / "b.npz", replace(here, landmarks=here.landmarks + 0.01))
    write_run(tmp_path / "c.npz", here)
    ended = run("compare", *(tmp_path / f"{n}.npz" for n in "abc"), "--segments")
    assert ended.status == 0, ended.err
    for words in ("start: B compared with A", "rest: C compared with A", "equal in every frame"):
        assert words in ended.out
    facts = run("compare", *(tmp_path / f"{n}.npz" for n in "abc"), "--segments", "--json").json
    assert [part["name"] for part in facts["segments"]] == ["start", "rest"]
    assert facts["segments"][0]["frames"] == 4
    assert len(facts["pairs"]) == 2


def test_wrong_input_is_one_sentence(run, tracked, tmp_path, runs):
    assert run("compare", tracked).status == 2
    ended = run("compare", tracked, tmp_path / "nothing.npz")
    assert ended.status == 2
    assert "nothing.npz" in ended.err
    ended = run("compare", tracked, tracked, "--frames", "500:600")
    assert ended.status == 2
    assert "have no frame in common" in ended.err
    ended = run("compare", runs / "truth.csv", runs / "truth.csv", "--segments")
    assert ended.status == 2
    assert "segments" in ended.err
