"""Views, scene and playback: what is shown of the frame, and going from frame to frame."""

from __future__ import annotations

from ...context import Context
from ...widgets.scene.bar import SceneBar
from .actions import SCENE_LAYERS, SCENE_SIDES, commands, playback_commands
from .controller import ViewController
from .memory import ViewMemory
from .scene import POINT_COLOURS


def register(context: Context) -> ViewController:
    """Let views and scene follow what is open, and offer what can be chosen of them."""
    view = ViewController(context)
    ViewMemory(context)
    context.actions.add(commands(context, view))
    context.actions.add(playback_commands(context.session, context.docks.transport))
    _add_scene_bar(context)
    return view


def _add_scene_bar(context: Context) -> None:
    action, dock = context.actions.action, context.docks.dock("scene")
    layers = [action(f"scene_{layer}") for layer in SCENE_LAYERS]
    colours = [action(f"points_{kind}") for kind in POINT_COLOURS]
    sides = [action(f"scene_from_{side}") for side in SCENE_SIDES]
    menus = [("Point colours", "theme", colours), ("Standard views", "scene", sides)]
    dock.setTitleBarWidget(SceneBar(dock.windowTitle(), layers, menus))
