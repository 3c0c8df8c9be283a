"""Files that fuzzing has found to bring readers down, each in its smallest form."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from stereotrack_core.errors import InputError


def _array(values) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


def _mmpose(**frame) -> bytes:
    places = {"keypoints": [[3.0, 4.0]] * 17, "keypoint_scores": [0.5] * 17}
    frame = {"instances": [places], **frame}
    return json.dumps({"meta_info": {}, "instance_info": [frame]}).encode()


def _coco(values) -> bytes:
    content = {
        "images": [{"id": 5, "file_name": "S/000002.png"}],
        "annotations": [{"id": 1, "image_id": 5, "category_id": 1, "keypoints": values}],
        "categories": [{"id": 1, "keypoints": ["nose"]}],
    }
    return json.dumps(content).encode()


def _result(values) -> bytes:
    return json.dumps([{"image_id": 2, "keypoints": values, "score": 1.0}]).encode()


DEEPLABCUT = b"scorer,a,a\nbodyparts,head,head\ncoords,x,y\n0,1.5,2.5\n"

REFUSED = {
    "no frame_id": ("keypoints, MMPose", _mmpose(), "has no frame_id"),
    "a list in a list of COCO": ("keypoints, COCO", _coco([[1, 2, [3]]]), "not a finite number"),
    "a list in a result": ("keypoints, COCO results", _result([[1, 2, []]]), "not a finite number"),
    "complex numbers": ("keypoints, array", _array(np.ones((2, 33, 2), complex)), "complex128"),
    "texts": ("keypoints, array", _array(np.full((2, 33, 2), "1")), "no NumPy array of numbers"),
    "a short line": (
        "keypoints, DeepLabCut",
        DEEPLABCUT.replace(b"coords,x,y", b"coords,x"),
        "not equally long",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_a_sentence(case, catalogue, tmp_path):
    name, content, words = REFUSED[case]
    reader = catalogue[name]
    (tmp_path / reader.file).write_bytes(content)
    with pytest.raises(InputError, match=words) as refused:
        reader.read(tmp_path / reader.file)
    assert refused.value.remedy


def test_a_point_without_a_name_is_one_that_is_not_known(catalogue, tmp_path):
    reader = catalogue["keypoints, MMPose"]
    content = json.loads(_mmpose(frame_id=1))
    content["meta_info"]["keypoint_id2name"] = {"0": "nose", "1": None}
    (tmp_path / reader.file).write_text(json.dumps(content))
    told, count = reader.read(tmp_path / reader.file)
    assert count == 1
    assert told.startswith("16 of keypoints that are no part")
    reader = catalogue["DLTdv, notes"]
    notes = json.loads(reader.content)
    notes["points"]["pt1"] = None
    (tmp_path / reader.file).write_text(json.dumps(notes))
    reader.read(tmp_path / reader.file)
