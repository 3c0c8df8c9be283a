"""A project finds its recording again; where it does not, it asks."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.project import opening
from stereotrack_core.project.clicks import place
from stereotrack_core.project.entries import save_reference
from stereotrack_core.project.opening import mounts_of_linux, mounts_of_macos
from stereotrack_core.project.project import Project
from stereotrack_core.project.whereabouts import project_path_for, projects_of


def test_project_and_recording_can_move_together(project, project_path, recording, tmp_path):
    project.close()
    home = tmp_path / "elsewhere"
    recording.folder.parent.rename(home)
    with Project.open(home / project_path.name) as moved:
        found = moved.find_recording()
        assert (found.folder, found.finding) == (home / "walk", None)
        assert moved.recording_place().absolute == str(home / "walk")


def test_a_recording_that_moved_is_known_by_its_fingerprint(
    project, recording, another_recording, tmp_path
):
    archive = tmp_path / "archive"
    archive.mkdir()
    recording.folder.rename(archive / "renamed")
    shutil.copytree(another_recording.folder, archive / "another")
    lost = project.find_recording()
    assert lost.folder is None
    assert lost.finding.severity == "error"
    assert str(recording.folder) in lost.finding.where
    found = project.find_recording([tmp_path / "missing", archive])
    assert found.folder == archive / "renamed"
    assert "has moved here" in found.finding.what
    assert project.find_recording().finding is None, "stores the new place"


def test_a_recording_is_never_written_to(recording, tmp_path):
    """Everything that a project does leaves the folder as it is, bytes and times."""

    def state():
        files = sorted(path for path in recording.folder.rglob("*"))
        return [
            (path, path.stat().st_mtime_ns, path.read_bytes() if path.is_file() else b"")
            for path in files
        ]

    before = state()
    with Project.create(tmp_path / "p.stereotrack", recording.folder) as project:
        project.apply(place(Click(1, "N_right", "head", (3.0, 4.0))))
        project.apply(save_reference("r", Reference(np.arange(3), np.zeros((3, 9, 3)))))
        project.find_recording()
        project.undo()
        project.save_copy(tmp_path / "copy.stereotrack")
    assert state() == before


def test_another_recording_in_the_old_place_is_not_taken_for_it(
    project, recording, another_recording
):
    """It has moved beside itself, and something else stands where it was."""
    recording.folder.rename(recording.folder.with_name("first-take"))
    another_recording.folder.rename(recording.folder)
    found = project.find_recording()
    assert found.folder == recording.folder.with_name("first-take")


def test_a_recording_that_changed_is_used_with_a_warning(project, recording):
    description = recording.folder / "recording.toml"
    description.write_text(description.read_text() + "\n# mended\n")
    found = project.find_recording()
    assert found.folder == recording.folder
    assert found.finding.severity == "warning"


def test_another_recording_has_to_be_wanted(project, another_recording):
    with pytest.raises(InputError, match="not the recording of the project"):
        project.use_recording(another_recording.folder)
    project.use_recording(another_recording.folder, even_another=True)
    assert project.find_recording().folder == another_recording.folder


def test_a_new_project_goes_beside_its_recording(recording, tmp_path, monkeypatch):
    beside = recording.folder.parent
    assert project_path_for(recording.folder) == beside / "walk.stereotrack"
    (beside / "walk.stereotrack").touch()
    assert project_path_for(recording.folder) == beside / "walk-2.stereotrack"
    monkeypatch.setattr("os.access", lambda path, mode: False)
    documents = tmp_path / "documents"
    assert project_path_for(recording.folder, documents) == documents / "walk.stereotrack"


def test_the_projects_of_a_recording_are_found(
    project, project_path, recording, another_recording, tmp_path
):
    documents = tmp_path / "documents"
    mine = documents / "mine.stereotrack"
    Project.create(mine, recording.folder).close()
    Project.create(documents / "another.stereotrack", another_recording.folder).close()
    (documents / "broken.stereotrack").write_text("no project")
    os.utime(mine, (1e9, 1e9))
    assert projects_of(recording.folder, documents) == (project_path, mine)
    project.close()
    recording.folder.parent.rename(tmp_path / "elsewhere")
    moved = tmp_path / "elsewhere" / "walk"
    assert projects_of(moved, documents) == (tmp_path / "elsewhere" / project_path.name,)
    assert {path.name for path in moved.parent.iterdir()} == {"walk", "another", project_path.name}


LINUX = r"""/dev/vda / ext4 rw 0 0
server:/home /shared nfs4 rw 0 0
/dev/vdb /shared/local\040disk ext4 rw 0 0
//nas/share /mnt/nas cifs rw 0 0
user@host: /mnt/remote fuse.sshfs rw 0 0
"""
MACOS = """/dev/disk1s1 on / (apfs, local, journaled)
//user@nas/share on /Volumes/nas (smbfs, nodev, nosuid)
/dev/disk2 on /Volumes/My (old) disk (hfs, local)
"""


@pytest.mark.parametrize(
    ("mounts", "path", "expected"),
    [
        (mounts_of_linux(LINUX), "/data/a.stereotrack", None),
        (mounts_of_linux(LINUX), "/shared/a/b.stereotrack", "nfs4"),
        (mounts_of_linux(LINUX), "/shared/local disk/b.stereotrack", None),
        (mounts_of_linux(LINUX), "/mnt/remote/x", "fuse.sshfs"),
        (mounts_of_macos(MACOS), "/Volumes/nas/x", "smbfs"),
        (mounts_of_macos(MACOS), "/Volumes/My (old) disk/x", None),
        ((), "/anything", None),
    ],
)
def test_network_drives_are_told_from_others(mounts, path, expected, monkeypatch):
    monkeypatch.setattr(opening, "machine_mounts", lambda: mounts)
    assert opening.network_type(Path(path)) == expected
