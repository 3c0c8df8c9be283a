"""Pose models as ONNX files, made here: they find the most red, green or blue place."""

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.crops import crop_around
from stereotrack_core.pose_model.detect import detect_keypoints
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE
from stereotrack_core.pose_model.onnx_model import PoseModel
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.tracking.recordings import HEIGHT, WIDTH, camera_towards_the_middle
from tests.tracking.scenes import CAMERAS

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

SIZE = (48, 64)  # width and height of the model's input
COLOURS = np.array([[0, 0, 255], [0, 255, 0], [255, 0, 0]])  # BGR: what each third point looks for


def model_file(path, *, simcc: bool):
    """A model whose point k is where colour k % 3 is strongest."""
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    width, height = SIZE
    count = len(COCO_17)
    weights = np.full((count, 3, 1, 1), -0.2, np.float32)
    for k in range(count):
        weights[k, k % 3] = 0.4
    initial = [onnx.numpy_helper.from_array(weights, "weights")]
    nodes = [
        helper.make_node("Conv", ["input", "weights"], ["raw"]),
        helper.make_node("AveragePool", ["raw"], ["maps"], kernel_shape=[4, 4], strides=[4, 4]),
    ]
    outputs = [helper.make_tensor_value_info("maps", kind, ["n", count, height // 4, width // 4])]
    if simcc:
        doubled = [2 * height, 2 * width]
        sizes = onnx.numpy_helper.from_array(np.array([1, count, *doubled], np.int64), "sizes")
        initial.append(sizes)
        nodes = [
            nodes[0],
            helper.make_node("Resize", ["raw", "", "", "sizes"], ["fine"], mode="nearest"),
            helper.make_node("ReduceMax", ["fine"], ["simcc_x"], axes=[2], keepdims=0),
            helper.make_node("ReduceMax", ["fine"], ["simcc_y"], axes=[3], keepdims=0),
        ]
        lengths = {"simcc_x": doubled[1], "simcc_y": doubled[0]}
        made = helper.make_tensor_value_info
        outputs = [made(name, kind, ["n", count, lengths[name]]) for name in lengths]
    given = helper.make_tensor_value_info("input", kind, ["n", 3, height, width])
    graph = helper.make_graph(nodes, "pose", [given], outputs, initial)
    opset = [helper.make_opsetid("", 13)]
    onnx.save(helper.make_model(graph, opset_imports=opset, ir_version=8), path)
    return path


def picture(places) -> np.ndarray:
    """Three coloured squares, seven pixels wide, on black."""
    result = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for (x, y), colour in zip(places, COLOURS, strict=True):
        result[y - 3 : y + 4, x - 3 : x + 4] = colour
    return result


PLACES = ((50, 40), (75, 60), (60, 80))


@pytest.mark.parametrize("simcc", [False, True])
@pytest.mark.parametrize("turned", [0, 90])
def test_a_model_says_where_things_are_in_the_picture(tmp_path, simcc, turned):
    model = PoseModel(model_file(tmp_path / "m.onnx", simcc=simcc))
    assert model.size == SIZE
    crop = crop_around(np.array([63.0, 60.0]), np.array([60.0, 70.0]), model.size, turned)
    places, sure = model.keypoints(picture(PLACES), crop)
    for k in range(len(COCO_17)):
        assert np.linalg.norm(places[k] - PLACES[k % 3]) < 5.0
    assert (sure > 0.3).all()


@pytest.fixture
def recording(tmp_path) -> Recording:
    """Two mono views in which three squares move."""
    folder = tmp_path / "rec"
    cameras = {n: camera_towards_the_middle(n, at) for n, at in zip("NO", CAMERAS[:2], strict=True)}
    for v, name in enumerate(cameras):
        (folder / name).mkdir(parents=True)
        for k in range(3):
            moved = [(x + 2 * k, y - 2 * v) for x, y in PLACES]
            write_png(folder / name / f"{k}.png", picture(moved))
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in cameras)
    write_recording_description(Recording(folder, "squares", 10.0, views, cameras))
    return open_recording(folder)


def test_a_recording_is_gone_through(recording, tmp_path):
    model = PoseModel(model_file(tmp_path / "m.onnx", simcc=True))
    with FrameReader(recording) as reader:
        found = detect_keypoints(reader, model, range(3))
    assert found.cameras == ("N", "O")
    assert set(found.keypoint.tolist()) <= set(COCO_17)
    for frame in range(3):
        own = found.of_frame(frame)
        green = own.place[(own.camera == "O") & (own.keypoint == COCO_17[1])]
        assert np.linalg.norm(green[0] - [75 + 2 * frame, 58]) < 5.0


def test_the_command_writes_a_table(recording, tmp_path, capsys):
    from stereotrack_core.program import main

    out = tmp_path / "keypoints.csv"
    model = model_file(tmp_path / "m.onnx", simcc=False)
    words = ["detect", str(recording.folder), "--model", str(model), "-o", str(out), "--views", "N"]
    assert main([*words, "--json"]) == 0
    assert '"cameras": "N"' in capsys.readouterr().out
    assert out.read_text().splitlines()[0].startswith("frame,view,keypoint,x,y,confidence")


def test_without_a_model_the_detector_is_needed(recording, tmp_path, monkeypatch, capsys):
    from stereotrack_core.program import main

    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "nothing"))
    words = ["detect", str(recording.folder), "-o", str(tmp_path / "keypoints.csv")]
    assert main(words) == 2
    assert "Run `stereotrack detector install`." in capsys.readouterr().err
    assert main([*words, "--layout", "coco17"]) == 2
    assert "--layout: the installed detector's points have names" in capsys.readouterr().err
    assert not (tmp_path / "keypoints.csv").exists()


def test_other_files_are_no_models(tmp_path):
    path = tmp_path / "m.onnx"
    path.write_bytes(b"rubbish")
    with pytest.raises(InputError, match="not an ONNX model"):
        PoseModel(path)
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    ends = [helper.make_tensor_value_info(name, kind, [1, 4]) for name in ("a", "b")]
    graph = helper.make_graph([helper.make_node("Relu", ["a"], ["b"])], "g", ends[:1], ends[1:])
    opset = [helper.make_opsetid("", 13)]
    onnx.save(helper.make_model(graph, ir_version=8, opset_imports=opset), path)
    with pytest.raises(InputError, match="no pose model: its input has the shape"):
        PoseModel(path)
