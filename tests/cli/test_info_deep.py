"""``info --deep`` measures pairs, clocks and depths, and ends with 2 where one is plainly wrong."""

import shutil


def test_a_sound_recording_has_no_errors(run, recording):
    ended = run("info", recording, "--deep", "--json")
    assert ended.status == 0
    assert not [f for f in ended.json["findings"] if f["severity"] == "error"]


def test_images_that_are_exchanged_are_an_error(run, recording, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(recording, folder)
    for name in ("N_{}.mp4", "N_{}_background.png"):
        files = [folder / name.format(side) for side in ("left", "right")]
        if files[0].exists():
            aside = files[0].rename(folder / f"aside{files[0].suffix}")
            files[1].rename(files[0])
            aside.rename(files[1])
    assert run("info", folder).status == 0
    ended = run("info", folder, "--deep", "--json")
    assert ended.status == 2
    [finding] = [f for f in ended.json["findings"] if f["severity"] == "error"]
    assert finding["where"] == "view N"
    assert "swap the files of left and right" in finding["remedy"]
    assert "wrong side" in run("info", folder, "--deep").out
