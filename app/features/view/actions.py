"""Commands about what the views and the scene show."""

from __future__ import annotations

from functools import partial

from ...context import Context
from ...services.actions import Command
from ...session.session import Session
from ...session.view_state import PointColour, ViewState
from ...widgets.camera.camera_grid import Arrangement, CameraGrid
from ...widgets.camera.click_marks import CLICK_OVERLAYS
from ...widgets.camera.display_panel import DisplayPanel
from ...widgets.camera.overlays import OVERLAYS
from ...widgets.camera.picture import PICTURE_KINDS, PictureKind
from ...widgets.scene.scene_view import SceneView
from ...widgets.timeline.transport import Transport
from .controller import ViewController
from .scene import POINT_COLOURS

_MENU, _GO = "&View", "&Go"
_OVERLAY_KEYS = {
    "outline": "O", "others": "Alt+O", "shading": "S", "wire": "W",
    "reference": "R", "points": "D", "correspondences": "C",
    "clicks": "Shift+C", "predictions": "Shift+X", "epipolar": "Shift+E",
    "residuals": "Shift+R", "fit": "Shift+O",
}  # fmt: skip
_OVERLAY_ICONS = {
    "outline": "model", "others": "compare", "reference": "reference", "points": "points",
    "correspondences": "correspondences", "clicks": "clicks", "predictions": "prediction",
    "epipolar": "epipolar", "residuals": "ruler", "fit": "fitted",
}  # fmt: skip
_KIND_KEYS: dict[PictureKind, str] = {
    "image": "F1", "left": "F2", "disparity": "F3", "foreground": "F4", "depth": "F5"
}  # fmt: skip
_LAYER_TIPS = {
    "ellipsoids": "Show or hide the two-sigma ellipsoids of hand and elbow positions in the "
    "scene, as estimated by the tracker.",
}
_KIND_TIPS: dict[PictureKind, str] = {
    "image": "Show the reference images: the right image of a stereo view.",
    "left": "Show the left images of the stereo views.",
    "disparity": "Show the disparity maps. Near is bright.",
    "foreground": "Show the foreground against the learned background.",
    "depth": "Show the depth maps. Near is bright.",
}
_ARRANGEMENTS: dict[Arrangement, tuple[str, str, str, str]] = {
    "grid": ("All views", "Show all views at the same size.", "G", "grid"),
    "one-and-more": (
        "One large view", "Show the active view large and the others small.",
        "Shift+M", "one-and-more",
    ),
}  # fmt: skip


SCENE_LAYERS = {
    "cloud": "points", "model": "model", "reference": "reference", "cameras": "camera",
    "floor": "grid", "ellipsoids": "ellipsoid",
}  # fmt: skip
"""Icons of the scene's layers."""

SCENE_SIDES = ("home", "front", "side", "top")


def commands(context: Context, view: ViewController) -> list[Command]:
    """Commands of the menu View."""
    session, docks, state = context.session, context.docks, context.view_state
    return [
        *_pictures(session, docks.views),
        *_overlays(session, view),
        *_arrangements(session, docks.views, view),
        *_zoom(session, state, view),
        *_light(session, view.light),
        *_scene(session, state, docks.scene, view),
    ]


def _pictures(session: Session, views: CameraGrid) -> list[Command]:
    def why_not(kind: PictureKind) -> str:
        if kind == "image":
            return session.no_recording()
        if session.no_depth():
            return session.no_depth()
        stereo = any(tile.view.kind == "stereo" for tile in views.tiles.values())
        only_stereo = kind in {"left", "disparity"} and not stereo
        return "This recording has no stereo view." if only_stereo else ""

    return [
        Command(
            f"show_{kind}", f"{_MENU}/Image", text, _KIND_TIPS[kind],
            partial(views.set_kind, kind), _KIND_KEYS[kind],
            "disparity" if kind == "disparity" else "foreground" if kind == "foreground" else "",
            partial(why_not, kind),
        )
        for kind, text in PICTURE_KINDS.items()
    ]  # fmt: skip


def _overlays(session: Session, view: ViewController) -> list[Command]:
    def why_not(name: str) -> str:
        return (
            session.no_depth() if name in {"points", "correspondences"} else session.no_recording()
        )

    return [
        Command(
            f"overlay_{name}", f"{_MENU}/Overlay", text, f"Show or hide {text.lower()}.",
            partial(view.toggle_overlay, name), _OVERLAY_KEYS[name],
            _OVERLAY_ICONS.get(name, ""), partial(why_not, name),
            partial(view.overlay_on, name),
        )
        for name, text in (*OVERLAYS.items(), *CLICK_OVERLAYS.items())
    ]  # fmt: skip


def _arrangements(session: Session, views: CameraGrid, view: ViewController) -> list[Command]:
    fixed = [
        Command(
            f"arrange_{kind}", _MENU, text, tip, partial(views.set_arrangement, kind),
            keys, icon, session.no_recording, partial(view.arranged, kind),
        )
        for kind, (text, tip, keys, icon) in _ARRANGEMENTS.items()
    ]  # fmt: skip
    return [
        *fixed,
        Command(
            "arrange_single", _MENU, "Single view", "Show only the active view, or all views "
            "again.",
            view.toggle_single, "M", "single", session.no_recording,
            lambda: views.arrangement == "single",
        ),
        Command(
            "next_view", _MENU, "Next view", "Make the next view the active one.",
            lambda: views.activate_next(1), "V", why_not=session.no_recording,
        ),
        Command(
            "previous_view", _MENU, "Previous view", "Make the previous view the active one.",
            lambda: views.activate_next(-1), "Shift+V", why_not=session.no_recording,
        ),
    ]  # fmt: skip


def _zoom(session: Session, state: ViewState, view: ViewController) -> list[Command]:
    return [
        Command(
            "zoom_in", _MENU, "Zoom in", "Zoom in on the active view.", lambda: view.zoom(1.25),
            "+", why_not=session.no_recording, section=True,
        ),
        Command(
            "zoom_out", _MENU, "Zoom out", "Zoom out of the active view.",
            lambda: view.zoom(0.8), "-", why_not=session.no_recording,
        ),
        Command(
            "zoom_fit", _MENU, "Fit to view", "Show the whole image in every view.",
            view.zoom_fit, "0", "", session.no_recording,
        ),
        Command(
            "keep_person", _MENU, "Zoom to the person",
            "Zoom every view to the person as located by clicks, the fit, a run or the reference, "
            "and follow the person until you zoom by hand. Choose this again to show whole images.",
            view.toggle_keep_person, "Z", "fit", session.no_recording,
            lambda: state.display.keep_person,
        ),
        Command(
            "loupe", _MENU, "Loupe", "Magnify the image under the cursor.", view.toggle_loupe,
            "L", "loupe", session.no_recording, lambda: state.display.loupe,
        ),
        Command(
            "loupe_corner", _MENU, "Loupe in the corner", "Show the loupe in a corner of the view "
            "so that it hides nothing around the cursor.", view.toggle_loupe_corner, "Shift+L",
            "", session.no_recording, lambda: state.display.loupe_in_corner,
        ),
    ]  # fmt: skip


def _light(session: Session, light: DisplayPanel) -> list[Command]:
    rows = [
        ("brighter", "Increase brightness", "Ctrl+Up", {"brightness": 5}),
        ("darker", "Decrease brightness", "Ctrl+Down", {"brightness": -5}),
        ("more_contrast", "Increase contrast", "Ctrl+Right", {"contrast": 10}),
        ("less_contrast", "Decrease contrast", "Ctrl+Left", {"contrast": -10}),
    ]
    commands = [
        Command(
            name, f"{_MENU}/Brightness and contrast",
            text, f"{text}. This affects the display only.",
            partial(light.change, **change), keys,
            why_not=session.no_recording,
        )
        for name, text, keys, change in rows
    ]  # fmt: skip
    reset = Command(
        "light_reset", f"{_MENU}/Brightness and contrast", "Reset brightness and contrast",
        "Show the images as recorded.",
        light.reset, icon="brightness", why_not=session.no_recording,
    )  # fmt: skip
    return [*commands, reset]


def _scene(
    session: Session, state: ViewState, scene: SceneView, view: ViewController
) -> list[Command]:
    def colour(kind: PointColour, text: str) -> Command:
        return Command(
            f"points_{kind}", f"{_MENU}/3-D scene", text,
            f"Colour the scene's {text[0].lower()}{text[1:]}.",
            lambda: state.colour_points(kind), why_not=session.no_depth,
            checked=lambda: state.point_colour == kind, icon="points",
        )  # fmt: skip

    layers = [
        Command(
            f"scene_{layer}", f"{_MENU}/3-D scene", f"Show {words}",
            _LAYER_TIPS.get(layer, f"Show or hide {words} in the scene."),
            partial(view.toggle_layer, layer), section=layer == "cloud",
            icon=SCENE_LAYERS[layer], checked=partial(scene.layer_visible, layer),
        )
        for layer, words in (
            ("cloud", "the measured points"), ("model", "the model"),
            ("reference", "the reference"), ("cameras", "the cameras"), ("floor", "the floor"),
            ("ellipsoids", "the uncertainty of hands and elbows"),
        )
    ]  # fmt: skip
    sides = [
        Command(
            f"scene_from_{view}", f"{_MENU}/3-D scene", text, f"{tip} Press {key} in the scene.",
            partial(scene.set_view, view), icon="scene", section=view == "home",
            why_not=session.no_recording,
        )
        for view, text, tip, key in (
            ("home", "Oblique view", "Look from the front and slightly from one side.",
            "R"),
            ("front", "Front view", "Look south, at a person facing north.", "F"),
            ("side", "Side view", "Look west.", "S"),
            ("top", "Top view", "Look down, with north up.", "T"),
        )
    ]  # fmt: skip
    colours = [colour(kind, text) for kind, text in POINT_COLOURS.items()]
    return [*colours, *layers, *sides]


def playback_commands(session: Session, transport: Transport) -> list[Command]:
    """Commands of the menu Go."""
    document = session.document

    def go(
        name: str, text: str, tip: str, by: int, keys: str, icon: str = "", *, section: bool = False
    ) -> Command:
        step = partial(document.step, by)
        return Command(name, _GO, text, tip, step, keys, icon, session.no_frames, section=section)

    return [
        Command(
            "play", _GO, "Play / pause", "Play at the recording's frame rate, or pause.",
            document.toggle_playing, "Space", "play", session.no_frames, lambda: document.playing,
        ),
        go("next", "Next frame", "Show the next frame.", 1, "Right", "step-forward"),
        go("previous", "Previous frame", "Show the frame before.", -1, "Left", "step-back"),
        go("next_comma", "Next frame (second key)", "Show the next frame.", 1, "."),
        go("previous_comma", "Previous frame (second key)", "Show the frame before.", -1, ","),
        go("ten_on", "Forward 10 frames",
        "Go forward by 10 frames.", 10, "Shift+Right", section=True),
        go("ten_back", "Back 10 frames", "Go back by 10 frames.", -10, "Shift+Left"),
        Command(
            "first", _GO, "First frame", "Go to the first frame.",
            lambda: document.go_to(0), "Home", "first", session.no_frames,
        ),
        Command(
            "last", _GO, "Last frame", "Go to the last frame.",
            lambda: document.go_to(document.frame_count - 1), "End", "last",
            session.no_frames,
        ),
        Command(
            "go_to", _GO, "Go to frame …", "Enter a frame number.",
            transport.type_frame, "Ctrl+G", "search", session.no_frames,
        ),
    ]  # fmt: skip
