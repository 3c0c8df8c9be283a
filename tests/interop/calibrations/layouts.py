"""The rig of these tests in the layouts of other tools."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import tomli_w

from stereotrack_core.geometry.rotation import vector_from_rotation
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.deciding import completed, decide
from stereotrack_core.interop.calibrations.formats import read_foreign
from tests.interop.calibrations.rigs import looking_at, rig

RIG = rig()


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def imported(*paths, size=None):
    """Cameras of files, without any data."""
    return list(decide(completed(read_foreign(paths), size=size)).cameras.values())


def sections(**changes):
    """Cameras in the layout of aniposelib."""
    return {
        f"cam_{i}": {
            "name": camera.name,
            "size": [640, 480],
            "matrix": camera.matrix.tolist(),
            "distortions": camera.distortions.tolist(),
            "rotation": vector_from_rotation(camera.camera_from_world.rotation).tolist(),
            "translation": camera.camera_from_world.translation.tolist(),
            **changes,
        }
        for i, camera in enumerate(RIG)
    }


def toml(path, content):
    return written(path, tomli_w.dumps(content))


YAML_MATRIX = """{name}: !!opencv-matrix
   rows: {rows}
   cols: {cols}
   dt: d
   data: [ {data} ]
"""


def opencv(**matrices):
    """YAML as OpenCV 4 writes it, lines broken in the middle of a matrix."""
    parts = ["%YAML:1.0\n---\n"]
    for name, value in matrices.items():
        if isinstance(value, str | int | float):
            parts.append(f"{name}: {value}\n")
            continue
        array = np.atleast_2d(value)
        data = ", ".join(f"{x:.16e}" for x in array.ravel()).replace(", ", ",\n       ", 1)
        rows, cols = array.shape
        parts.append(YAML_MATRIX.format(name=name, rows=rows, cols=cols, data=data))
    return "".join(parts)


def pair():
    left, right = RIG[0], RIG[1]
    return left, right, right.camera_from_world @ left.world_from_camera


def stereo():
    """A pair in one file of OpenCV."""
    left, right, right_from_left = pair()
    return opencv(
        image_width=640, image_height=480, M1=left.matrix, D1=left.distortions, M2=right.matrix,
        D2=right.distortions, R=right_from_left.rotation, T=1000 * right_from_left.translation,
    )  # fmt: skip


def ros(name, camera, rectification, projection):
    """One camera as camera_calibration of ROS writes it."""
    rows = {
        "camera_matrix": camera.matrix,
        "distortion_coefficients": camera.distortions,
        "rectification_matrix": rectification,
        "projection_matrix": projection,
    }
    text = f"image_width: 640\nimage_height: 480\ncamera_name: {name}\n"
    text += "distortion_model: plumb_bob\n"
    for key, value in rows.items():
        array = np.atleast_2d(value)
        text += f"{key}:\n  rows: {array.shape[0]}\n  cols: {array.shape[1]}\n"
        text += f"  data: {array.ravel().tolist()}\n"
    return text


def qualisys(cameras):
    root = ET.Element("calibration", {"type": "regular"})
    parent = ET.SubElement(root, "cameras")
    for camera in cameras:
        one = ET.SubElement(parent, "camera", {"serial": camera.name, "model": "Miqus Video"})
        seen = {"left": "10", "top": "20", "right": "649", "bottom": "499"}
        ET.SubElement(one, "fov_video", seen)
        axes = camera.camera_from_world.rotation * np.array([[1], [-1], [-1]])
        place = 1000 * camera.position_world
        stated = {f"r{i + 1}{j + 1}": repr(float(axes[i, j])) for i in range(3) for j in range(3)}
        stated |= {key: repr(float(value)) for key, value in zip("xyz", place, strict=True)}
        ET.SubElement(one, "transform", stated)
        k1, k2, p1, p2, k3 = camera.distortions
        lens = {
            "focalLengthU": 64 * camera.matrix[0, 0], "focalLengthV": 64 * camera.matrix[1, 1],
            "centerPointU": 64 * (camera.matrix[0, 2] + 10),
            "centerPointV": 64 * (camera.matrix[1, 2] + 20), "skew": 0.0,
            "radialDistortion1": k1, "radialDistortion2": k2, "radialDistortion3": k3,
            "tangentalDistortion1": p1, "tangentalDistortion2": p2,
        }  # fmt: skip
        ET.SubElement(one, "intrinsic", {key: repr(float(value)) for key, value in lens.items()})
    return ET.tostring(root, encoding="unicode")


def matlab(*, new):
    """A pair 120 mm apart as MATLAB has it: pixels from 1, transposed where it multiplies so."""
    left, right = RIG[0], RIG[1]
    turned = looking_at((0, 0, 0), (0.05, 1, 0)).rotation
    turned = turned @ looking_at((0, 0, 0), (0, 1, 0)).rotation.T
    offset = [-120.0, 1.0, 2.0]
    lenses = []
    for camera in (left, right):
        matrix = camera.matrix.copy()
        matrix[:2, 2] += 1.0
        k1, k2, p1, p2, k3 = camera.distortions
        lens = {"K": matrix} if new else {"IntrinsicMatrix": matrix.T}
        lenses.append(
            {"ImageSize": [480, 640], "RadialDistortion": [k1, k2, k3], "WorldUnits": "millimeters",
             "TangentialDistortion": [p1, p2], "Skew": 0, **lens}
        )  # fmt: skip
    both = {"CameraParameters1": lenses[0], "CameraParameters2": lenses[1]}
    if new:
        full = np.eye(4)
        full[:3, :3], full[:3, 3] = turned, offset
        both["PoseCamera2"] = {"Dimensionality": 3, "A": full}
    else:
        both |= {"RotationOfCamera2": turned.T, "TranslationOfCamera2": offset}
    places = [RigidTransform.identity(), RigidTransform(turned, np.array(offset) / 1000)]
    pairs = zip((left, right), ("left", "right"), places, strict=True)
    return both, [replace(one, name=name, camera_from_world=place) for one, name, place in pairs]


_ZED = {
    "LEFT_CAM_HD": "fx=700.1 fy=700.2 cx=640.5 cy=360.25 k1=-0.17 k2=0.02 p1=0.0001 p2=-0.0002 "
    "k3=-0.003",
    "RIGHT_CAM_HD": "fx=701 fy=702 cx=650 cy=355",
    "LEFT_CAM_VGA": "fx=350 fy=350 cx=336 cy=188",
    "RIGHT_CAM_VGA": "fx=351 fy=351 cx=337 cy=189",
    "RIGHT_DISTO": "k1=0.5 k2=-0.1 p1=0 p2=0 k3=0.01 k4=0.8 k5=-0.06 k6=0.02",
    "STEREO": "Baseline=119.9 TY=0.05 TZ=-0.4 CV_HD=0.007 CV_VGA=0.007 RX_HD=0.002 RX_VGA=0.002 "
    "RZ_HD=-0.001 RZ_VGA=-0.001",
}
ZED = "\n\n".join("\n".join([f"[{name}]", *facts.split()]) for name, facts in _ZED.items())
