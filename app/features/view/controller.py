"""Views, scene and timeline follow what is known, tell what a person does there, and are kept."""

import dataclasses
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.person_boxes import Box, person_boxes
from stereotrack_core.tracking.presets import UserPreset, named

from ...context import Context
from ...session.changes import RECORDING, Part
from ...session.jobs import Job, NewestJob, Task
from ...session.messages import stored_texts
from ...session.tracking import Chosen
from ...session.view_state import CLICK_OVERLAYS, PICTURE_KINDS
from ...widgets.camera.overlays import OVERLAYS
from ...widgets.scene.content import Ellipsoid, frustum_corners, frustum_depth
from ...widgets.style.theme import current_theme
from .pictures import pictures_of
from .scene import ellipsoids_of, scene_of

_NOBODY_KNOWN = (
    "The position of the person is not known yet. Click two landmarks in a view, or run the "
    "tracker; the views zoom in at the next frame."
)


class ViewController:
    """Brings views, scene and timeline together with the facts."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self._state, self._docks = context.view_state, context.docks
        self._rig_held = False
        session, state, docks = self._session, self._state, self._docks
        watch = session.changes.watch
        watch(RECORDING, self._show_recording)
        watch(Part.INSTANT, self._on_instant)
        watch(Part.FRAME, lambda: docks.timeline.set_frame(session.document.frame))
        watch(Part.FRAME, lambda: docks.transport.set_frame(session.document.frame))
        watch(Part.LENGTH, self._on_length)
        watch(Part.DISPLAY, lambda: docks.views.set_display(state.displayed))
        watch(Part.DISPLAY, lambda: docks.scene.set_highlighted(state.display.highlighted))
        watch(Part.SCENE, self._show_scene_soon)
        watch(Part.SELECTION, self._on_selection)
        watch(Part.PICTURES, self._on_wanted)
        watch(Part.ACTIVE_VIEW, lambda: docks.views.set_active(state.active_view))
        watch(Part.WORKSPACE, self._on_workspace)
        docks.views.activated.connect(state.activate)
        docks.timeline.frame_requested.connect(session.document.visit)
        docks.timeline.selection_changed.connect(state.select)
        docks.transport.number.changed.connect(session.document.visit)
        docks.dock("scene").visibilityChanged.connect(self._on_scene_shown)
        self._switch_on_as_stored()

    def _show_recording(self) -> None:
        recording = self._session.document.recording
        aspects = _aspects(recording) if recording is not None else {}
        self._docks.views.set_views(tuple(self._state.views.values()), aspects)
        self._docks.scene.begin_anew()
        self._rig_held = False
        self._on_length()

    def _on_instant(self) -> None:
        told, overlays = self._session.instant.told, self._state.displayed.overlays
        if told is not None:
            self._docks.views.show_pictures(pictures_of(told, self._state.wanted(), overlays))
        self._show_scene_soon()
        self._context.actions.refresh_soon()

    def _on_wanted(self) -> None:
        self._docks.views.show_kinds(self._state.kinds)
        self._docks.views.arrange(self._state.arrangement)
        self._session.instant.tell_soon()
        self._context.actions.refresh_soon()

    def _on_length(self) -> None:
        recording, count = self._session.document.recording, self._session.document.frame_count
        fps = recording.fps if recording is not None else 1.0
        self._docks.timeline.set_range(count, fps)
        self._docks.transport.set_range(count, fps)

    def _on_selection(self) -> None:
        timeline, frames = self._docks.timeline, self._state.selection
        if timeline.selection != frames:  # what was chosen elsewhere
            timeline.set_selection(frames)
            timeline.selection_changed.emit(frames)
        self._context.actions.refresh_soon()

    def _on_workspace(self) -> None:
        if self._docks.workspace:
            self._look_at(cameras=self._docks.workspace == "calibrate")
            self._on_scene_shown()
            self._context.actions.refresh_soon()

    def _on_scene_shown(self) -> None:
        """Draw the scene; its points are asked for only if they are not there."""
        self._show_scene_soon()
        if not self._session.instant.settled():
            self._session.instant.tell_soon()

    def _show_scene_soon(self) -> None:
        self._docks.redraw.soon(self._show_scene)

    def _show_scene(self) -> None:
        instant, scene, state = self._session.instant.told, self._docks.scene, self._state
        if instant is None or not scene.is_seen():
            return
        if state.hidden:  # nobody shall see what is known already, but who asks for it
            overlays = state.displayed.overlays
            instant = dataclasses.replace(
                instant,
                reference=instant.reference if "reference" in overlays else None,
                meshes=instant.meshes if "outline" in overlays else (),
                ghosts=instant.ghosts if "others" in overlays else (),
            )
        frame, entry, meshes = instant.frame_set.index, self._session.runs.active, instant.meshes
        tracked = entry.at(frame) if entry is not None else None
        ellipsoids: tuple[Ellipsoid, ...] = ()
        if entry is not None and tracked is not None and scene.layer_visible("ellipsoids"):
            ellipsoids = ellipsoids_of(entry, tracked)
        annotates, fit = self._docks.workspace == "annotate", state.fit
        if annotates and fit is not None and fit.frame == frame:
            meshes = fit.meshes
        shown = state.point_colour, state.display.highlighted, ellipsoids
        scene.show_scene(scene_of(instant, meshes, *shown, dark=current_theme().is_dark))

    def _look_at(self, *, cameras: bool) -> None:
        """Point the scene at the whole rig or at the person."""
        recording = self._session.document.recording
        if cameras and recording is not None:
            rig = tuple(recording.cameras.values())
            places = [camera.position_world for camera in rig]
            middle = np.mean(places, axis=0) * (1.0, 1.0, 0.0)
            pictures = [frustum_corners(camera, frustum_depth(rig)) for camera in rig]
            self._docks.scene.hold(np.vstack([places, middle, *pictures]))
        elif self._rig_held:
            self._docks.scene.hold(None)
        self._rig_held = cameras

    def toggle_layer(self, layer: str) -> None:
        scene = self._docks.scene
        scene.set_layer_visible(layer, not scene.layer_visible(layer))
        self._session.instant.tell_soon()

    def _switch_on_as_stored(self) -> None:
        names = stored_texts(self._context.settings, "overlays_shown")
        keep = bool(self._context.settings.value("keep_person", False, type=bool))
        self._state.change_display(keep_person=keep)
        if names is not None:
            known = frozenset(names) & frozenset((*OVERLAYS, *CLICK_OVERLAYS))
            self._state.change_display(overlays=known)

    def toggle_overlay(self, name: str) -> None:
        self._state.toggle_overlay(name)
        self._context.settings.setValue("overlays_shown", sorted(self._state.display.overlays))

    def toggle_keep_person(self) -> None:
        keep = not self._state.display.keep_person
        self._state.change_display(keep_person=keep)
        self._context.settings.setValue("keep_person", keep)
        tiles = self._docks.views.tiles.values()
        if keep and not any(tile.camera.knows_person() for tile in tiles):
            self._context.notifier.say(_NOBODY_KNOWN)

    def zoom(self, factor: float) -> None:
        if (camera := self._docks.views.active_camera()) is not None:
            camera.zoom_by(factor)

    def zoom_fit(self) -> None:
        if self._state.display.keep_person:
            self.toggle_keep_person()
        self._docks.views.fit()


def _aspects(recording: Recording) -> dict[str, float]:
    """Width by height of the images of each view as they are shown, upright."""
    return {
        view.name: (camera.width / camera.height) ** (-1 if view.display_rotation % 180 else 1)
        for view in recording.views
        for camera in (recording.reference_camera(view),)
    }


_SETTING = "window"
_QUIET_MS = 1000


class ViewMemory:
    """Keeps in the project what is shown, selected and tracked with; not in a read-only one."""

    def __init__(self, context: Context) -> None:
        self._context, self._session, self._state = context, context.session, context.view_state
        self._project: Project | None = None
        self._kept: Any = None
        self._now: dict[str, Any] | None = None
        self._timer = context.session.later(self._keep, _QUIET_MS)
        watch = context.session.changes.watch
        watch(Part.PROJECT_OPENED, self._on_opened)
        watch(Part.PROJECT_CLOSING, self._on_closing)
        shown = Part.FRAME | Part.WORKSPACE | Part.PICTURES | Part.DISPLAY
        watch(shown | Part.SELECTION | Part.THRESHOLD | Part.SETTINGS, self._note)

    def _on_opened(self) -> None:
        project = self._session.project.project
        if project is None or project is self._project or not self._session.project.makes:
            return  # where only a picture is made, nothing is looked up and nothing left behind
        self._project, self._now = project, None
        self._kept = project.view_settings.get(_SETTING)
        # somebody else may have written it
        with suppress(KeyError, TypeError, ValueError, AttributeError, InputError):
            self._show(self._kept or {})
        self._note()

    def _on_closing(self) -> None:
        self._keep()
        self._timer.stop()
        self._project = self._now = None

    def _note(self) -> None:
        document, docks, state = self._session.document, self._context.docks, self._state
        if self._project is None or document.recording is None or not docks.workspace:
            return
        selected, chosen = state.selection, self._session.track.chosen
        self._now = {
            "frame": document.frame,
            "workspace": docks.workspace,
            "pictures": dict(state.kinds),
            "light": {"": [state.display.brightness, state.display.contrast]},
            "selection": None if selected is None else [selected.start, selected.stop],
            "threshold": state.threshold,
            "settings": chosen,
        }
        self._timer.start()

    def _keep(self) -> None:
        project, now = self._project, self._now
        if project is None or project.read_only or now is None:
            return
        chosen: Chosen = now["settings"]
        both = (named(chosen.preset, each) for each in (chosen.base, chosen.settings))
        now = {**now, "settings": [dataclasses.asdict(each) for each in both]}
        if now == self._kept:
            return
        try:
            project.view_settings.set(_SETTING, now)
        except InputError as error:
            self._context.notifier.say(f"Display settings could not be saved: {error.what}.")
        self._kept = now

    def _show(self, kept: Mapping[str, Any]) -> None:
        """Show what was shown last, but for what was asked for when opening."""
        document, docks, state = self._session.document, self._context.docks, self._state
        asked = self._session.asked
        if not asked.frame and document.frame == 0:
            document.go_to(int(kept["frame"]))
        names = {space.name for space in docks.workspaces if not space.why_not()}
        wanted = str(kept["workspace"]).strip().lower()
        if wanted in names - {docks.workspace} and not asked.workspace:
            docks.show_workspace(wanted)
        for name, kind in kept["pictures"].items():
            if kind in PICTURE_KINDS:
                state.choose_kind(kind, name)
        state.set_light(*map(float, kept["light"].get("", (0.0, 1.0))))
        state.set_threshold(float(kept["threshold"]))
        if kept["selection"] and state.selection is None:
            state.select(range(*map(int, kept["selection"])))
        if not asked.tracks:  # what runs already is made with what is shown
            base, own = (UserPreset(**each) for each in kept["settings"])
            self._session.track.put(Chosen(own.name, base.settings, own.settings))
            self._session.trials.cancel()  # nobody has asked for one by opening a project


_OPEN_ZOOMED = "open_zoomed"
_MARGIN = 0.12  # share of the longer side of a person's box that is left on each side


class FirstZoom:
    """Looks for the person in the background; who has clicked into a view by then is left alone."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._looking = NewestJob(context.tasks)
        context.session.changes.watch(Part.PROJECT_FOLLOWED, self._look)
        context.session.changes.watch(Part.RECORDING_CLOSED, self._looking.give_up)
        context.docks.views.activated.connect(self._looking.give_up)

    def chosen(self) -> bool:
        return bool(self._context.settings.value(_OPEN_ZOOMED, True, type=bool))

    def toggle(self) -> None:
        self._context.settings.setValue(_OPEN_ZOOMED, not self.chosen())

    def _look(self) -> None:
        self._looking.give_up()
        recording = self._context.session.document.recording
        if recording is None or recording.guessed or not self.chosen():
            return  # before cameras are known all has to be seen: a box may miss the person

        def look(task: Task) -> dict[str, Box]:
            try:
                return person_boxes(recording, task.work)
            except InputError:
                return {}  # what cannot be read is told by who shows it

        def show(boxes: dict[str, Box]) -> None:
            homes = {name: _wider(*box) for name, box in boxes.items()}
            self._context.docks.views.set_homes(homes)

        self._looking.run(Job("looking for the person", look, show))


def _wider(left: float, top: float, right: float, bottom: float) -> QRectF:
    more = _MARGIN * max(right - left, bottom - top)
    return QRectF(QPointF(left, top), QPointF(right, bottom)).adjusted(-more, -more, more, more)
