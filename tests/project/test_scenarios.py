"""Named stretches and cameras that are left out are edits of the project."""

from stereotrack_core.annotation.click import Click
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import delete_entry
from stereotrack_core.project.marks import use_camera
from stereotrack_core.project.project import Project
from stereotrack_core.project.scenarios import keep_scenario, scenarios_of, segments_of
from stereotrack_core.project.schema import SCENARIO
from stereotrack_core.recording.description import Segment


def test_a_scenario_collects_its_stretches_and_comes_back(project, project_path, recording):
    for name, frames in (("crossing", range(5, 9)), ("fast", range(2)), (" crossing", range(3))):
        project.apply(keep_scenario(name, frames))
    crossing = Segment("crossing", 0, 3), Segment("crossing", 5, 9)
    assert set(scenarios_of(project)) == {*crossing, Segment("fast", 0, 2)}
    assert project.undo().words == "name frames 0 to 2 crossing"
    assert set(scenarios_of(project)) == {crossing[1], Segment("fast", 0, 2)}
    project.apply(delete_entry(SCENARIO, "fast"))
    project.close()
    with Project.open(project_path, read_only=True) as again:
        assert segments_of(again, recording) == (*recording.segments, crossing[1])


def test_a_camera_is_left_out_and_used_again_while_its_clicks_stay(project):
    clicks = (Click(0, "S_cam", "head", (1.0, 2.0)), Click(0, "N_right", "head", (1.0, 2.0)))
    project.apply(place_clicks(clicks))
    assert project.apply(use_camera("S_cam", used=True)) is None
    project.apply(use_camera("S_cam", used=False))
    assert project.marks.unused_cameras() == {"S_cam"}
    assert [one.camera for one in project.clicks.used()] == ["N_right"]
    assert project.clicks.count() == 2
    assert project.undo().words == "leave out camera S_cam"
    assert len(project.clicks.used()) == 2
    project.redo()
    project.apply(use_camera("S_cam", used=True))
    assert not project.marks.unused_cameras()
