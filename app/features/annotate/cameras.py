"""Which cameras count: one that contradicts the others can be left out, and used again."""

from functools import partial

from stereotrack_core.project.marks import use_camera

from ...services.actions import Command, Menu
from .panels import AnnotationPanels, click_cameras

CAMERA_COMMANDS = tuple(f"annotate-camera-{place}" for place in range(1, 10))
"""A switch for each of the first nine views."""


def camera_commands(p: AnnotationPanels) -> list[Command]:
    """A switch for each view: whether its clicks count."""

    def cameras() -> tuple[str, ...]:
        return tuple(click_cameras(p.recording))

    def says(place: int) -> str:
        if p.recording is None or place >= len(cameras()):
            return f"Use view {place + 1}"
        camera = cameras()[place]
        return f"Use {p.recording.camera_names().get(camera, camera)}"

    def is_used(place: int) -> bool:
        return not there(place) or cameras()[place] not in p.clicking.annotating.unused()

    def toggle(place: int) -> None:
        edit = use_camera(cameras()[place], used=not is_used(place))
        p.edit_selection(lambda *_: edit)

    def there(place: int) -> bool:
        return place < len(cameras())

    command = Menu("&Annotate/&Cameras that count", p.no_edit).command
    return [
        command(name, f"Use view {place + 1}", "Let the clicks of this "
                "view count in triangulation, fits, suggestions and exports. They stay in the "
                "project.", partial(toggle, place), says=partial(says, place),
                checked=partial(is_used, place), shown=partial(there, place))
        for place, name in enumerate(CAMERA_COMMANDS)
    ]  # fmt: skip
