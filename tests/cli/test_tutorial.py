"""Every command of the tutorial does what the tutorial says."""

import re
import shlex
from pathlib import Path

import pytest

from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.project import Project
from stereotrack_core.recording.folder import open_recording
from tests.annotation.simulated_clicks import AnnotationCase, simulated_clicks

PAGE = Path(__file__).resolve().parents[2] / "docs" / "tutorial.md"
CLICKED = (99, 110)


def click(film: Path, project: Path) -> int:
    """Click what is seen of the landmarks, as the tutorial asks for; how many clicks that took."""
    case = AnnotationCase("tutorial", 2.0, 1, depth=False)
    made = simulated_clicks(open_recording(film), case, 0).by_frame
    clicks = tuple(one for frame in CLICKED for one in made[frame])
    with Project.create(project, project.with_suffix(""), who="A") as opened:
        opened.apply(place_clicks(clicks))
    return len(clicks)


@pytest.mark.slow
def test_the_commands_of_the_tutorial(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = PAGE.read_text(encoding="utf-8")
    assert f"frames {CLICKED[0]} and {CLICKED[1]}" in page
    lost, said = {}, ""
    for block in re.findall(r"```\n(stereotrack .*?)```", page, flags=re.DOTALL):
        for command in block.splitlines():
            program, *arguments = shlex.split(command)
            assert program == "stereotrack"
            if "--clicks" in arguments and not Path("walk.stereotrack").exists():
                assert f"{click(Path('film'), Path('walk.stereotrack'))} clicks" in page
            ended = run(*arguments)
            said += ended.out
            if arguments[0] == "evaluate" and not {"--failures", "--against"} & set(arguments):
                lost[arguments[1]] = run(*arguments, "--json").json["lost_percent"]
    assert "No problems found." in said
    told = {"both.npz": 0.2, "north.npz": 18.1, "mended.npz": 2.7}
    assert lost == pytest.approx(told, abs=3.0)
    assert all(f"{percent} %" in page for percent in (0.2, 18.1, 2.7))
    assert Path("subject.toml").is_file()
