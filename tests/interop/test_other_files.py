"""Files of other programs that hold no landmarks, or say too little of them."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.recording.landmarks import LANDMARKS


def _refused(path):
    """Complaints about a file, read as a trajectory and as labels."""
    with pytest.raises(InputError) as as_trajectory:
        read_trajectory(path)
    complaints = [str(as_trajectory.value)]
    if not is_trajectory(path):
        with pytest.raises(InputError) as as_labels:
            read_labels(LabelSource(path, None, LANDMARKS))
        complaints.append(str(as_labels.value))
    return complaints


def test_what_a_table_of_anipose_is(tmp_path):
    parts = ("x", "y", "z", "error", "ncams", "score")
    header = [f"{name}_{part}" for name in ("head", "hip") for part in parts]
    rows = [[*header, "M_00", "fnum"], ["1.0"] * (len(header) + 2)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    complaints = _refused(path)
    assert len(complaints) == 2
    assert all("anipose's table of 3-D points" in complaint for complaint in complaints)


@pytest.mark.parametrize(
    ("suffix", "words"), [(".bvh", "rotations of a skeleton"), (".mot", "joint angles")]
)
def test_what_files_without_landmarks_are(tmp_path, suffix, words):
    path = tmp_path / f"a{suffix}"
    path.write_text("HIERARCHY\n")
    assert is_trajectory(path)
    assert words in _refused(path)[0]
