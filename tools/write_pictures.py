"""The pictures of the README and of the documentation, made by the workbench on the demo.

``python tools/write_pictures.py DEMO DOCS`` keeps recording and runs in the folder DEMO.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.calibrate.board import Board, chessboard

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.program import WindowProgram
    from stereotrack_core.geometry.camera import Camera
    from stereotrack_core.geometry.transform import RigidTransform
    from stereotrack_core.recording.description import Recording

FRAME = 60
PRESETS = ("thesis", "accurate")
SIZE, SMALL = (1400, 840), (1240, 740)
BOARD = ("9x6", 0.09)  # that is calibrated with
POSITIONS = 40  # places in which it is rendered
TUTORIAL_FRAMES = (99, 110)  # frames that the tutorial says to click
CALM_LOOKS = 3  # so often nothing is under way before a picture is taken


def main(demo: Path, docs: Path) -> int:
    """Make the demo and its runs where they are not there yet, then the pictures."""
    from app.start import load_qt, prepare
    from stereotrack_core.demo import copied_demo

    places = copied_demo(demo)
    stored = demo / "runs"  # not beside the recording, where the window would offer them
    stored.mkdir(exist_ok=True)
    film = places.recording
    runs = [_tracked(film, stored / f"{name}.npz", "--preset", name) for name in PRESETS]
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    prepare(needs_screen=False)
    load_qt()
    docs.mkdir(parents=True, exist_ok=True)
    done = [
        _picture(film, runs[-1:], "track", docs / "workbench.png"),
        _picture(film, runs, "tune", docs / "comparison.png", "comparison"),
        _picture(film, runs[::-1], "review", docs / "review.png", "failures"),
        _calibration(film, demo / "boards", docs),
        _annotate(film, docs / "annotate.png"),
        _tutorial(demo / "tutorial", docs),
    ]
    _import(film, docs)
    return 0 if all(done) else 1


def _tracked(recording: Path, path: Path, *options: str) -> Path:
    from stereotrack_core.program import main as command_line

    if not path.is_file():
        command_line(["track", str(recording), "-o", str(path), *options])
    return path


def _program() -> WindowProgram:
    """A window in dark colours."""
    from app.program import WindowProgram
    from app.widgets.style.theme import apply_theme

    program = WindowProgram()
    apply_theme(program.app, "dark")
    return program


def _picture(
    recording: Path,
    runs: list[Path],
    workspace: str,
    picture: Path,
    panel: str = "runs",
    frame: int = FRAME,
) -> bool:
    from app.session.changes import Part
    from stereotrack_core.cli.output import say

    program = _program()
    context = program.context
    context.view_state.change_display(keep_person=True)
    # the last one that is opened is the active one
    context.session.changes.watch(Part.READY, lambda: _open_runs(program, runs))
    context.session.changes.watch(Part.READY, lambda: context.docks.bring_up(panel))
    failures = context.session.failures
    context.session.changes.watch(
        Part.TASKS, lambda: failures.go(1) if failures.listed and failures.chosen is None else None
    )
    context.session.open(recording, frame=frame, workspace=workspace)
    return program.picture(picture, say, SIZE)


def _calibration(recording: Path, boards: Path, docs: Path) -> bool:
    """The workspace Calibrate on rendered boards before the cameras of the recording."""
    from PySide6.QtCore import QEventLoop, QTimer

    from app.shell.dialogs import write_picture
    from stereotrack_core.cli.output import say
    from stereotrack_core.recording.folder import open_recording

    if not boards.is_dir():
        _render_boards(open_recording(recording), boards)
    program = _program()
    program.window.resize(*SMALL)
    program.window.show()
    calibration = program.features.calibrate.calibration
    program.context.docks.show_workspace("calibrate")
    calibration.add_folder(boards)
    calibration.set_board(chessboard(*BOARD))
    while calibration.state.step != "world":
        calibration.go_on()
        calm = 0
        while calm < CALM_LOOKS:  # widgets are laid out after what they show has come
            loop = QEventLoop()
            QTimer.singleShot(200, loop.quit)
            loop.exec()
            busy = calibration.state.busy is not None or not program.context.tasks.settled()
            calm = 0 if busy else calm + 1
        if calibration.state.step == "lenses":
            write_picture(docs / "calibrate-lenses.png", program.window.grab())
    return program.picture(docs / "calibrate-world.png", say, SMALL)


def _annotate(recording: Path, picture: Path) -> bool:
    """The workspace Annotate with a frame in the making: two views are clicked."""
    project = _clicked(recording, recording, (FRAME,), ("N", "O"))
    done = _picture(recording, [], "annotate", picture, "body")
    project.unlink()
    return done


def _tutorial(folder: Path, docs: Path) -> bool:
    """The pictures of the tutorial, from files that its commands make."""
    from stereotrack_core.program import main as command_line
    from stereotrack_core.project.entries import choose
    from stereotrack_core.project.project import Project
    from stereotrack_core.project.schema import REFERENCE

    film, walk = folder / "film", folder / "walk"
    truth, project = str(film / "reference.csv"), str(walk.with_suffix(".stereotrack"))
    stored = folder / "runs"
    stored.mkdir(parents=True, exist_ok=True)
    runs = {name: stored / f"{name}.npz" for name in ("both", "north", "mended")}
    if not film.is_dir():
        command_line(["simulate", str(film), "--views", "NO", "--motion", "cross-arms+tie-shoes"])
    if not walk.is_dir():
        calibration = str(film / "calibration.toml")
        command_line(
            ["import", "recording", str(film), "-o", str(walk), "--calibration", calibration]
        )
    _clicked(film, walk, TUTORIAL_FRAMES)
    options = {"both": [], "north": ["--views", "N"]}
    options["mended"] = [*options["north"], "--clicks", project]
    for name, path in runs.items():
        _tracked(walk, path, *options[name])
    frame = TUTORIAL_FRAMES[-1]
    done = _picture(walk, [], "annotate", docs / "tutorial-clicks.png", "body", frame)
    command_line(["import", "labels", truth, "--into", project])
    with Project.open(Path(project)) as opened:
        opened.apply(choose(REFERENCE, "reference"))  # as the window does
    for picture, shown in (("errors", ("both",)), ("mended", ("north", "mended"))):
        chosen = [runs[name] for name in shown]
        place = docs / f"tutorial-{picture}.png"
        done = _picture(walk, chosen, "review", place, "failures", frame) and done
    return done


def _clicked(
    film: Path, recording: Path, frames: Sequence[int], views: Sequence[str] = ("N", "O")
) -> Path:
    """A project with clicks of what some views see of the truth of `film`."""
    from stereotrack_core.project.clicks import place_clicks
    from stereotrack_core.project.project import Project
    from stereotrack_core.recording.folder import open_recording
    from tests.annotation.simulated_clicks import AnnotationCase, simulated_clicks

    case = AnnotationCase("pictures", 2.0, 1, depth=False)
    made = simulated_clicks(open_recording(film), case, 0).by_frame
    clicks = [one for frame in frames for one in made[frame]]
    path = recording.with_suffix(".stereotrack")
    path.unlink(missing_ok=True)  # of earlier pictures
    with Project.create(path, recording, who="A") as project:
        project.apply(place_clicks(tuple(one for one in clicks if one.camera[0] in views)))
    return path


def _import(recording: Path, docs: Path) -> None:
    """The first step of the wizard on the videos of two views."""
    from app.features.project.importing.sources_page import look
    from app.features.project.importing.wizard import ImportWizard
    from app.shell.dialogs import write_picture
    from stereotrack_core.recording.folder import open_recording

    views = open_recording(recording).views[:2]
    files = [one.frames for view in views for one in (view.left, view.image) if one is not None]
    program = _program()
    looked = look([recording / file for file in files])
    wizard = ImportWizard(looked, program.context.tasks, lambda _path: None, program.window)
    wizard.show()
    write_picture(docs / "import-sources.png", wizard.grab())
    wizard.reject()


def _render_boards(recording: Recording, folder: Path) -> None:
    """Pictures of a board in random places before the cameras of two views, one folder for each."""
    import numpy as np

    from stereotrack_core.geometry.transform import RigidTransform
    from stereotrack_core.recording.writing import write_png
    from stereotrack_core.simulation.rig import Sensor
    from tests.calibrate.board_pictures import BoardRenderer, board_in_view

    rng, board = np.random.default_rng(1), chessboard(*BOARD)
    cameras = [one for name, one in recording.cameras.items() if name[0] in "NO"]
    places: list[RigidTransform] = []
    while len(places) < POSITIONS:
        place = board_in_view(cameras[len(places) % 4], board, rng, (1.0, 2.6))
        if len(places) % 2 or all(_sees(camera, place, board) for camera in cameras):
            places.append(place)
    away = RigidTransform(np.eye(3), np.array([0.0, 0.0, 50.0]))
    for number, camera in enumerate(cameras):
        (folder / camera.name).mkdir(parents=True)
        sensor = Sensor(np.ones((1, 3)), 1.0, 0.6, 0.5, (1, number))
        renderer = BoardRenderer(camera, board, sensor)
        for k, place in enumerate(places):
            seen = (camera.camera_from_world @ place).rotation[2, 2] > 0.0
            shown = place if seen else away @ place  # the back of a board shows no squares
            write_png(folder / camera.name / f"{k:03d}.png", renderer.picture(shown, k))


def _sees(camera: Camera, place: RigidTransform, board: Board) -> bool:
    """Whether a camera sees the front of the whole board."""
    pixels = camera.project(place.apply(board.corners))
    inside = ((pixels > 8.0) & (pixels < (camera.width - 9.0, camera.height - 9.0))).all()
    return bool(inside and (camera.camera_from_world @ place).rotation[2, 2] > 0.4)


def _open_runs(program: WindowProgram, runs: list[Path]) -> None:
    for run in runs:
        program.features.files.open_run(run)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as nobody:
        # no one's own layout, theme or shortcuts
        os.environ["XDG_CONFIG_HOME"] = nobody
        sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
