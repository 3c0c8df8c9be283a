"""Marker sets of motion laboratories, and axes of files that the person contradicts."""

import ezc3d
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.interop.landmark_file import Stated, world_from_axes
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.recording.landmarks import LANDMARKS, write_landmarks

UPRIGHT = {
    "hip": (0.09, 0.0, 0.92),
    "shoulder": (0.17, 0.0, 1.40),
    "elbow": (0.25, 0.0, 1.12),
    "wrist": (0.27, 0.10, 0.89),
    "hand": (0.2777, 0.1385, 0.8015),
}
"""Joint centres of the right side of somebody who faces north: metres east, north and up."""


def _markers(side):
    """Places on the skin of one side of that person, so that the joint centres follow from them."""
    sign = -1.0 if side == "L" else 1.0

    def at(place, east=0.0, north=0.0):
        x, y, z = UPRIGHT[place]
        return sign * (x + east), y + north, z

    across, deep = 0.2506, 0.15  # metres between both ASIS, and from them to the PSIS
    asis = (sign * across / 2, 0.24 * deep + 0.0099, 0.92 + 0.30 * across + 0.0109)
    return {
        "asis": asis,
        "psis": (sign * 0.045, asis[1] - deep, asis[2]),
        "acromion": (sign * 0.17, 0.0, 1.40 + 0.17 * 0.34),
        "lateral_elbow": at("elbow", 0.04),
        "medial_elbow": at("elbow", -0.04),
        "radial_wrist": at("wrist", 0.0, 0.03),
        "ulnar_wrist": at("wrist", 0.0, -0.03),
        "second_knuckle": at("hand", 0.0, 0.035),
        "fifth_knuckle": at("hand", 0.0, -0.035),
        "middle_knuckle": at("hand"),
        "front_head": (sign * 0.07, 0.09, 1.60),
        "back_head": (sign * 0.07, -0.09, 1.60),
        "side_head": (sign * 0.08, 0.0, 1.60),
        "knee": (sign * 0.09, 0.0, 0.48),
        "heel": (sign * 0.09, -0.05, 0.03),
    }


def _write_c3d(path, labels, axes="x,y,z", screen=("+X", "+Z"), frames=4):
    """Write markers by their labels; `axes` are those of the file that point east, north, up."""
    points = np.array(list(labels.values()), dtype=float) @ world_from_axes(axes)
    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [100.0], ["mm"]
    point["LABELS"]["value"] = list(labels)
    for key, value in zip(("X_SCREEN", "Y_SCREEN"), screen, strict=True):
        if value:
            file.add_parameter("POINT", key, value)
    file["data"]["points"] = np.ones((4, len(labels), frames))
    file["data"]["points"][:3] = 1000.0 * points.T[..., None]
    file.write(str(path))
    return path


def _write_trc(path, labels, axes="z,x,y"):
    points = np.array(list(labels.values()), dtype=float) @ world_from_axes(axes)
    names = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"]
    values = ["100.0", "100.0", "2", str(len(labels)), "m"]
    cells = [f"{value:.6f}" for value in points.ravel()]
    rows = [
        "\t".join(("PathFileType", "4", "(X/Y/Z)", "trial.trc")),
        "\t".join(names),
        "\t".join(values),
        "\t".join(["Frame#", "Time", *(cell for name in labels for cell in (name, "", ""))]),
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(len(labels)) for axis in "XYZ"),
        "",
        *("\t".join([str(k), f"{k / 100}", *cells]) for k in range(2)),
    ]
    path.write_text("\n".join(rows) + "\n")
    return path


def _labelled(names, prefix=""):
    """Markers of both sides by label; `names` maps places to labels with {S} for the side."""
    pairs = [(side, place) for side in "LR" for place in names]
    return {f"{prefix}{names[place].replace('{S}', s)}": _markers(s)[place] for s, place in pairs}


WHOLE = {"head": (0.0, 0.0, 1.6)} | {
    f"{side}_{name}": (sign * x, y, z)
    for side, sign in (("left", -1), ("right", 1))
    for name, (x, y, z) in UPRIGHT.items()
    if name != "wrist"
}
SETS = {
    "Plug-in Gait": {
        "asis": "{S}ASI", "psis": "{S}PSI", "acromion": "{S}SHO", "lateral_elbow": "{S}ELB",
        "medial_elbow": "{S}MEP", "radial_wrist": "{S}WRA", "ulnar_wrist": "{S}WRB",
        "middle_knuckle": "{S}FIN", "front_head": "{S}FHD", "back_head": "{S}BHD",
        "heel": "{S}HEE",
    },
    "IOR": {
        "asis": "{S}_IAS", "psis": "{S}_IPS", "acromion": "{S}_SAE", "lateral_elbow": "{S}_HLE",
        "medial_elbow": "{S}_HME", "radial_wrist": "{S}_RSP", "ulnar_wrist": "{S}_USP",
        "second_knuckle": "{S}_HM2", "fifth_knuckle": "{S}_HM5", "front_head": "{S}_HDF",
        "back_head": "{S}_HDB", "heel": "{S}_FCC",
    },
    "Qualisys animation and sports": {
        "asis": "Waist{S}Front", "psis": "Waist{S}Back", "acromion": "{S}ShoulderTop",
        "lateral_elbow": "{S}ElbowOut", "medial_elbow": "{S}ElbowIn",
        "radial_wrist": "{S}WristIn", "ulnar_wrist": "{S}WristOut", "second_knuckle": "{S}HandIn",
        "fifth_knuckle": "{S}HandOut", "side_head": "Head{S}", "heel": "{S}HeelBack",
    },
    "Rajagopal (OpenSim)": {
        "asis": "{S}ASI", "psis": "{S}PSI", "acromion": "{S}ACR", "lateral_elbow": "{S}LEL",
        "medial_elbow": "{S}MEL", "radial_wrist": "{S}FAradius", "ulnar_wrist": "{S}FAulna",
        "heel": "{S}CAL",
    },
    "gait2392 (OpenSim)": {
        "asis": "{S}.ASIS", "psis": "{S}.PSIS", "acromion": "{S}.Acromium",
        "lateral_elbow": "{S}.Elbow.Lat", "medial_elbow": "{S}.Elbow.Med",
        "radial_wrist": "{S}.Wrist.Lat", "ulnar_wrist": "{S}.Wrist.Med", "heel": "{S}.Heel",
    },
    "Rizzoli (Leardini)": {
        "asis": "{S}ASIS", "psis": "{S}PSIS", "acromion": "{S}A", "lateral_elbow": "{S}EL",
        "medial_elbow": "{S}EM", "radial_wrist": "{S}RS", "ulnar_wrist": "{S}US", "heel": "{S}CA",
    },
}  # fmt: skip


@pytest.mark.parametrize(("name", "prefix"), [*((name, "") for name in SETS), ("IOR", "Kim:")])
def test_usual_marker_sets_tell_the_landmarks(tmp_path, name, prefix):
    path = _write_c3d(tmp_path / "a.c3d", _labelled(SETS[name], prefix))
    found = read_trajectory(path)
    texts = [note.what for note in found.notes]
    assert any(name in text for text in texts), texts
    known = [k for k, one in enumerate(LANDMARKS) if one != "head" or "head" in str(SETS[name])]
    expected = np.array([WHOLE[one] for one in LANDMARKS])
    np.testing.assert_allclose(found.points[0, known], expected[known], atol=2e-3)
    assert any("Harrington" in text and "10 mm" in text for text in texts)
    if len(known) < len(LANDMARKS):
        assert np.isnan(found.points[:, LANDMARKS.index("head")]).all()
        assert "no label tells head" in texts


def test_a_lateral_elbow_marker_alone_says_how_far_it_is_off(tmp_path):
    names = {place: label for place, label in SETS["Plug-in Gait"].items() if "medial" not in place}
    found = read_trajectory(_write_c3d(tmp_path / "a.c3d", _labelled(names)))
    elbow = found.points[0, LANDMARKS.index("left_elbow")]
    np.testing.assert_allclose(elbow, _markers("L")["lateral_elbow"], atol=1e-6)
    assert any("lateral marker itself, within about 40 mm" in note.what for note in found.notes)


def test_joint_centres_of_a_model_go_before_markers(tmp_path):
    labels = _labelled(SETS["Plug-in Gait"]) | {"LSJC": (-0.2, 0.01, 1.41), "LFEP": (-0.1, 0, 0.9)}
    found = read_trajectory(_write_c3d(tmp_path / "a.c3d", labels))
    for name, label in (("left_shoulder", "LSJC"), ("left_hip", "LFEP")):
        np.testing.assert_allclose(found.points[0, LANDMARKS.index(name)], labels[label], atol=1e-6)


def test_names_go_before_marker_sets(tmp_path):
    labels = _labelled(SETS["Plug-in Gait"]) | {"LShoulder": (-0.2, 0.0, 1.5), "x": (0.5, 0, 0.7)}
    stated = Stated({"x": "right_hand"})
    found = read_trajectory(_write_c3d(tmp_path / "a.c3d", labels), stated)
    np.testing.assert_allclose(found.points[0, 0], (-0.2, 0.0, 1.5), atol=1e-6)
    hand = found.points[0, LANDMARKS.index("right_hand")]
    np.testing.assert_allclose(hand, (0.5, 0.0, 0.7), atol=1e-6)


def test_two_people_in_a_file_are_not_mixed(tmp_path):
    one = _labelled(SETS["Plug-in Gait"], "A:")
    two = {k: (x + 2, y, z) for k, (x, y, z) in _labelled(SETS["Plug-in Gait"], "B:").items()}
    path = _write_c3d(tmp_path / "a.c3d", one | two)
    with pytest.raises(InputError, match=r"2 people \(A, B\)"):
        read_trajectory(path)
    found = read_trajectory(path, Stated({"B:LFIN": "left_hand"}))
    assert (found.points[..., 0] > 1.5).all()


@pytest.mark.parametrize("labels", [WHOLE, _labelled(SETS["Plug-in Gait"])], ids=["own", "markers"])
def test_a_c3d_that_states_down_for_up_is_refused(tmp_path, labels):
    path = _write_c3d(tmp_path / "a.c3d", labels, screen=("-X", "-Z"))
    with pytest.raises(InputError, match=r"-z points up .* trunk points along z") as caught:
        read_trajectory(path)
    assert "--axes -x,-y,z for an upright person" in caught.value.remedy
    upright = read_trajectory(path, Stated(world_from_file=world_from_axes("-x,-y,z")))
    assert upright.points[0, LANDMARKS.index("head"), 2] == pytest.approx(1.6)
    as_stated = read_trajectory(path, Stated(world_from_file=world_from_axes("-x,y,-z")))
    assert as_stated.points[0, LANDMARKS.index("head"), 2] == pytest.approx(-1.6)


def _turned(labels, turn):
    """Markers turned about the hips."""
    pivot = np.array([0.0, 0.0, 0.92])
    return {name: tuple(pivot + turn @ (place - pivot)) for name, place in labels.items()}


def test_who_lies_is_asked_for_and_then_taken_as_stated(tmp_path):
    lying = _turned(WHOLE, world_from_axes("x,z,-y"))
    path = _write_c3d(tmp_path / "a.c3d", lying)
    with pytest.raises(InputError, match="--axes x,y,z for a person who lies"):
        read_trajectory(path)
    found = read_trajectory(path, Stated(world_from_file=np.eye(3)))
    np.testing.assert_allclose(found.points[0], [lying[name] for name in LANDMARKS], atol=1e-6)


def test_blanks_between_all_cells_of_a_trc(tmp_path):
    path = _write_trc(tmp_path / "a.trc", WHOLE)
    path.write_text("\n".join("  ".join(line.split()) for line in path.read_text().split("\n")))
    found = read_trajectory(path)
    np.testing.assert_allclose(found.points[1], [WHOLE[name] for name in LANDMARKS], atol=1e-6)


def test_lost_markers_at_zero_are_missing_and_told(tmp_path):
    """Programs without a sign for what they lost write zeros."""
    path = _write_trc(tmp_path / "a.trc", WHOLE)
    lines = path.read_text().splitlines()
    lines[6] = "\t".join([*lines[6].split("\t")[:2], *(["0.0"] * 3 * len(WHOLE))])
    path.write_text("\n".join(lines) + "\n")
    found = read_trajectory(path)
    assert np.isnan(found.points[0]).all()
    assert np.isfinite(found.points[1]).all()
    assert any("at 0, 0, 0 taken as missing" in note.what for note in found.notes)


def test_landmarks_are_turned_into_a_world_whose_z_is_not_up(tmp_path):
    path = _write_trc(tmp_path / "a.trc", WHOLE)
    found = read_trajectory(path, Stated(up=Upright("y")))
    upright = Upright("y").points(found.points[0])
    np.testing.assert_allclose(upright, [WHOLE[name] for name in LANDMARKS], atol=1e-6)
    assert found.points[0, LANDMARKS.index("head"), 1] == pytest.approx(1.6)
    table = tmp_path / "a.csv"
    write_landmarks(table, found)
    again = read_trajectory(table, Stated(up=Upright("y")))
    np.testing.assert_allclose(again.points, found.points, atol=1e-5)
    with pytest.raises(InputError, match="z points up"):
        read_trajectory(table)
