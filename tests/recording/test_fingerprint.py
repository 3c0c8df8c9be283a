"""The fingerprint knows a recording again wherever it lies, and no other."""

from __future__ import annotations

import shutil

from stereotrack_core.recording.folder import fingerprint, open_recording


def test_it_stays_when_the_folder_moves_or_the_reference_is_mended(small_recording, tmp_path):
    before = fingerprint(open_recording(small_recording.folder))
    assert len(before) == 32
    elsewhere = tmp_path.parent / f"{tmp_path.name} elsewhere"
    shutil.copytree(small_recording.folder, elsewhere)
    reference = elsewhere / "reference.csv"
    reference.write_text(reference.read_text().replace("1.400000", "1.410000"))
    assert fingerprint(open_recording(elsewhere)) == before


def test_it_changes_with_description_calibration_and_images(small_recording):
    folder = small_recording.folder
    seen = {fingerprint(open_recording(folder))}
    for change in (
        lambda: append(folder / "recording.toml"),
        lambda: append(folder / "calibration.toml"),
        lambda: append(folder / "N_left/000.png"),
        lambda: (folder / "W_right/007.png").unlink(),
    ):
        change()
        seen.add(fingerprint(open_recording(folder)))
    assert len(seen) == 5


def append(path):
    with path.open("ab") as file:
        file.write(b"\n# more\n")
