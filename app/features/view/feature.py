"""Views, scene and playback: what is shown of the frame, and going from frame to frame."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from ...context import Context
from ...services.actions import Command, Menu
from ...services.docks import Transport
from ...session.session import Session, unless
from ...session.view_state import CLICK_OVERLAYS, PICTURE_KINDS, PictureKind, ViewState
from ...widgets.camera.overlays import LEADING, OVERLAYS
from ...widgets.scene.scene_view import SceneView, scene_bar
from .controller import FirstZoom, ViewController, ViewMemory
from .scene import POINT_COLOURS

_MENU = "&View"
_OVERLAY_KEYS = {
    "outline": ("O", "model"), "others": ("Alt+O", "compare"), "shading": ("S", ""),
    "wire": ("W", ""), "reference": ("R", "reference"), "points": ("D", "points"),
    "keypoints": ("Shift+K", ""), "correspondences": ("C", "correspondences"),
    "clicks": ("Shift+C", "clicks"),
    "predictions": ("Shift+X", "prediction"), "epipolar": ("Shift+E", "epipolar"),
    "residuals": ("Shift+R", "ruler"), "fit": ("Shift+O", "fitted"),
}  # fmt: skip
_IN_ANNOTATE = " In Annotate it is off until you ask for it, because it would lead your clicks."
_KINDS: dict[PictureKind, tuple[str, str]] = {
    "image": ("Shift+F2", "Show the reference images: the right image of a stereo view."),
    "left": ("F2", "Show the left images of the stereo views."),
    "disparity": ("F3", "Show the disparity maps. Near is bright."),
    "foreground": ("F4", "Show the foreground against the learned background."),
    "depth": ("F5", "Show the depth maps. Near is bright."),
}
SCENE_LAYERS = {
    "cloud": ("points", "the measured points", ""),
    "model": ("model", "the model", ""),
    "reference": ("reference", "the reference", ""),
    "cameras": ("camera", "the cameras", ""),
    "floor": (
        "grid", "the floor", "Show or hide the floor with metres along its edges, and the axes: "
        "x points east, y north and z up.",
    ),
    "ellipsoids": (
        "ellipsoid", "the uncertainty of hands and elbows", "Show or hide the two-sigma ellipsoids "
        "of hand and elbow positions in the scene, as estimated by the tracker.",
    ),
}  # fmt: skip
"""Icon and words of the scene's layers, and a tip where the words do not tell it."""

SCENE_SIDES = {
    "home": ("Oblique view", "Look from the front and slightly from one side.", "Ctrl+Alt+1"),
    "front": ("Front view", "Look south, at a person facing north.", "Ctrl+Alt+2"),
    "side": ("Side view", "Look west.", "Ctrl+Alt+3"),
    "top": ("Top view", "Look down, with north up.", "Ctrl+Alt+4"),
}


def _pictures(session: Session, state: ViewState) -> list[Command]:
    def why_not(kind: PictureKind) -> str:
        if kind == "image":
            return session.no_recording()
        stereo = any(view.kind == "stereo" for view in state.views.values())
        stereo |= kind not in {"left", "disparity"}
        return session.no_depth() or unless(stereo, "This recording has no stereo view.")

    return [
        Menu(f"{_MENU}/Image", partial(why_not, kind)).command(
            f"show_{kind}", PICTURE_KINDS[kind], tip, partial(state.choose_kind, kind), keys,
            kind if kind in {"disparity", "foreground"} else "",
        )
        for kind, (keys, tip) in _KINDS.items()
    ]  # fmt: skip


def _overlays(session: Session, state: ViewState, view: ViewController) -> list[Command]:
    def no_keypoints() -> str:
        none = "The project has no predictions of a detector. Import predictions first."
        return session.no_recording() or unless(session.keypoints.drawn, none)

    depth = dict.fromkeys(("points", "correspondences"), session.no_depth)
    needs = {**depth, "keypoints": no_keypoints}
    return [
        Menu(f"{_MENU}/Overlay", needs.get(name, session.no_recording)).command(
            f"overlay_{name}", text,
            f"Show or hide {text.lower()}.{_IN_ANNOTATE if name in LEADING else ''}",
            partial(view.toggle_overlay, name), keys, icon,
            checked=lambda name=name: name in state.displayed.overlays,
        )
        for name, text in (*OVERLAYS.items(), *CLICK_OVERLAYS.items())
        for keys, icon in (_OVERLAY_KEYS[name],)
    ]  # fmt: skip


def _arrangements(session: Session, state: ViewState) -> list[Command]:
    command = Menu(_MENU, session.no_recording).command
    return [
        *(command(f"arrange_{icon}", text, tip, do, keys, icon,
                  checked=lambda icon=icon: state.arrangement == icon)
          for icon, text, tip, do, keys in (
            ("grid", "All views", "Show all views at the same size.",
             partial(state.arrange, "grid"), "G"),
            ("one-and-more", "One large view", "Show the active view large and the others small.",
             partial(state.arrange, "one-and-more"), "Shift+M"),
            ("single", "Single view", "Show only the active view, or all views again.",
             lambda: state.arrange("grid" if state.arrangement == "single" else "single"), "M"))),
        command("next_view", "Next view", "Make the next view the active one.",
                partial(state.activate_next, 1), "V"),
        command("previous_view", "Previous view", "Make the previous view the active one.",
                partial(state.activate_next, -1), "Shift+V"),
    ]  # fmt: skip


def _zoom(
    session: Session, state: ViewState, view: ViewController, first_zoom: FirstZoom
) -> list[Command]:
    command = Menu(_MENU, session.no_recording).command
    return [
        command("zoom_in", "Zoom in", "Zoom in on the active view.", partial(view.zoom, 1.25), "+",
                section=True),
        command("zoom_out", "Zoom out", "Zoom out of the active view.", partial(view.zoom, 0.8),
                "-"),
        command("zoom_fit", "Fit to view", "Show the whole image in every view.", view.zoom_fit,
                "0"),
        command("keep_person", "Zoom to the person", "Zoom every view to the person as located by "
                "clicks, the fit, a run, the reference or movement, and follow the person until "
                "you zoom by hand. Choose this again to show whole images.",
                view.toggle_keep_person, "Z", "fit", checked=lambda: state.display.keep_person),
        Command("open_zoomed", _MENU, "Open zoomed to the person", "Open recordings with every "
                "view zoomed to where the person moves. Press 0 for whole images.",
                first_zoom.toggle,
                checked=first_zoom.chosen),
        command("loupe", "Loupe", "Magnify the image under the cursor.",
                lambda: state.change_display(loupe=not state.display.loupe), "L", "loupe",
                checked=lambda: state.display.loupe),
    ]  # fmt: skip


def _light(session: Session, state: ViewState) -> list[Command]:
    command = Menu(f"{_MENU}/Brightness and contrast", session.no_recording).command
    changes = [
        command(name, text, f"{text}. This affects the display only.",
                partial(state.change_light, **change), keys)
        for name, text, keys, change in (
            ("brighter", "Increase brightness", "Ctrl+Up", {"brightness": 0.05}),
            ("darker", "Decrease brightness", "Ctrl+Down", {"brightness": -0.05}),
            ("more_contrast", "Increase contrast", "Ctrl+Right", {"contrast": 1.15}),
            ("less_contrast", "Decrease contrast", "Ctrl+Left", {"contrast": 1 / 1.15}),
        )
    ]  # fmt: skip
    reset = command("light_reset", "Reset brightness and contrast", "Show the images as recorded.",
                    partial(state.set_light, 0.0, 1.0), icon="brightness")  # fmt: skip
    return [*changes, reset]


def _scene(
    session: Session, state: ViewState, scene: SceneView, view: ViewController
) -> list[Command]:

    menu = f"{_MENU}/3-D scene"
    colours = [
        Menu(menu, session.no_depth).command(
            f"points_{kind}", text, f"Colour the scene's {text[0].lower()}{text[1:]}.",
            partial(state.colour_points, kind), icon="points",
            checked=lambda kind=kind: state.point_colour == kind,
        )
        for kind, text in POINT_COLOURS.items()
    ]  # fmt: skip
    layers = [
        Menu(menu).command(
            f"scene_{layer}", f"Show {words}",
            tip or f"Show or hide {words} in the scene.", partial(view.toggle_layer, layer),
            icon=icon, checked=partial(scene.layer_visible, layer), section=layer == "cloud",
        )
        for layer, (icon, words, tip) in SCENE_LAYERS.items()
    ]  # fmt: skip
    sides = [
        Menu(menu, session.no_recording).command(
            f"scene_from_{side}", text, tip, partial(scene.set_view, side), keys, "scene",
            section=side == "home",
        )
        for side, (text, tip, keys) in SCENE_SIDES.items()
    ]  # fmt: skip
    return [*colours, *layers, *sides]


def _playback(session: Session, transport: Transport) -> list[Command]:
    document, command = session.document, Menu("&Go", session.no_frames).command
    step = partial(partial, document.step)

    return [
        command("play", "Play / pause", "Play at the recording's frame rate, or pause.",
                document.toggle_playing, "Space", "play", checked=lambda: document.playing),
        command("next", "Next frame", "Show the next frame.", step(1), "Right", "step-forward"),
        command("previous", "Previous frame", "Show the frame before.", step(-1), "Left",
                "step-back"),
        command("next_comma", "Next frame (second key)", "Show the next frame.", step(1), "."),
        command("previous_comma", "Previous frame (second key)", "Show the frame before.",
                step(-1), ","),
        command("ten_on", "Forward 10 frames", "Go forward by 10 frames.", step(10), "Shift+Right",
                section=True),
        command("ten_back", "Back 10 frames", "Go back by 10 frames.", step(-10), "Shift+Left"),
        command("first", "First frame", "Go to the first frame.", partial(document.go_to, 0),
                "Home", "first"),
        command("last", "Last frame", "Go to the last frame.",
                lambda: document.go_to(document.frame_count - 1), "End", "last"),
        command("go_to", "Go to frame …", "Enter a frame number.", transport.type_frame, "Ctrl+G",
                "search"),
    ]  # fmt: skip


def register(context: Context) -> ViewController:
    """Let views and scene follow what is open, and offer what can be chosen of them."""
    view = ViewController(context)
    ViewMemory(context)
    session, docks, state = context.session, context.docks, context.view_state

    def why_not(own: Callable[[], str]) -> str:
        hidden = "The views are hidden here. Choose another workspace first."
        seen = not docks.workspace or docks.middle.currentWidget() is docks.views
        return own() or unless(seen, hidden)

    commands = (
        *_pictures(session, state),
        *_overlays(session, state, view),
        *_arrangements(session, state),
        *_zoom(session, state, view, FirstZoom(context)),
        *_light(session, state),
        *_playback(session, docks.transport),
    )
    context.actions.add([replace(one, why_not=partial(why_not, one.why_not)) for one in commands])
    context.actions.add(_scene(session, state, docks.scene, view))
    action, dock = context.actions.action, context.docks.dock("scene")
    layers = [action(f"scene_{layer}") for layer in SCENE_LAYERS]
    colours = [action(f"points_{kind}") for kind in POINT_COLOURS]
    sides = [action(f"scene_from_{side}") for side in SCENE_SIDES]
    menus = [("Point colours", "theme", colours), ("Standard views", "scene", sides)]
    dock.setTitleBarWidget(scene_bar(dock.windowTitle(), layers, menus))
    return view
