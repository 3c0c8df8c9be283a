"""How the panels follow the facts."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal, Slot

from stereotrack_core.body.mesh import PartMesh

from ..features.annotate.clicking.live_fit import ShownFit
from ..features.review.curves import curves_of, lanes_of
from ..features.view.certainty import ellipsoids_of
from ..features.view.scene import PointColour, scene_of
from ..session.counting import counted
from ..session.pictures import Instant, pictures_of
from ..session.stated_errors import heading_words, score_words
from ..widgets.plots.error_plot import ErrorPlot
from ..widgets.scene.content import Ellipsoid
from ..widgets.scene.surroundings import frustum_corners, frustum_depth
from ..widgets.style.theme import current_theme
from .status import number_rows, status_words
from .window_panels import TITLES

if TYPE_CHECKING:
    from .main_window import MainWindow

_SCENE_DELAY_MS = 30
_SCENE_PATIENCE_MS = 150


class PanelFollower(QObject):
    """Fills the panels when a fact they show has changed; tells what a person does there.

    Signals
    -------
    threshold_moved : ()
        The plot's threshold was dragged, or the plot was made anew.
    """

    threshold_moved = Signal()

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = window
        self._plot_title = ""
        self.point_colour: PointColour = "view"
        self._highlighted = ""
        self._fit: ShownFit | None = None
        self._scene_timer = QTimer(self, singleShot=True, interval=_SCENE_DELAY_MS)
        self._scene_timer.timeout.connect(self._show_scene)
        self._scene_waits = QElapsedTimer()
        self._rig_held = False
        self._make_plot("angular error")
        stored = window.view.stored_overlays()
        if stored is not None:
            self.change_display(overlays=stored)
        keep = window.settings.value("keep_person", False, type=bool)
        self.change_display(keep_person=bool(keep))
        self._connect()
        self.show_settings()

    # ---- connections

    def _connect(self) -> None:
        w = self._w
        w.instant.ready.connect(self._on_instant)
        w.document.frame_changed.connect(self._on_frame_changed)
        w.document.count_changed.connect(self._on_count_changed)
        w.document.findings_changed.connect(self.show_findings)
        w.project.opened.connect(self.write_title)
        w.project.closed.connect(self.write_title)
        w.judging.judged.connect(self.show_judgements)
        w.grid.kinds_changed.connect(w.instant.tell_soon)
        w.grid.hovered.connect(w.pixel_label.setText)
        w.grid.limb_clicked.connect(self.highlight)
        w.scene.limb_clicked.connect(self.highlight)
        w.timeline.frame_requested.connect(self._go_to)
        w.timeline.selection_changed.connect(self._on_selection)
        w.transport.frame_requested.connect(self._go_to)
        w.display_panel.changed.connect(self._on_light)
        w.grid.active_changed.connect(self._show_light)
        w.parameters.settings_changed.connect(self.use_settings)
        w.runs_panel.activated.connect(lambda i: w.runs.activate(w.runs.entries[i]))
        w.runs_panel.shown.connect(lambda i, shown: w.runs.show(w.runs.entries[i], visible=shown))
        w.runs_panel.renamed.connect(
            lambda i, name: w.run_work.keeper.rename(w.runs.entries[i], name)
        )
        w.docks["scene"].visibilityChanged.connect(w.instant.tell_soon)

    def look_at(self, *, cameras: bool) -> None:
        """Let the scene hold the whole rig, or the person."""
        recording = self._w.document.recording
        if cameras and recording is not None:
            rig = tuple(recording.cameras.values())
            places = [camera.position_world for camera in rig]
            middle = np.mean(places, axis=0) * (1.0, 1.0, 0.0)
            pictures = [frustum_corners(camera, frustum_depth(rig)) for camera in rig]
            self._w.scene.hold(np.vstack([places, middle, *pictures]))
        elif self._rig_held:
            self._w.scene.hold(None)
        self._rig_held = cameras

    def _make_plot(self, title: str) -> None:
        """Make the plot anew when it shows another measure."""
        if title == self._plot_title:
            return
        self._plot_title = title
        w = self._w
        old = w.plot_stack.widget(0) if w.plot_stack.count() > 1 else None
        threshold = w.plot.threshold if old is not None else None
        if old is not None:
            w.timeline.visible_range_changed.disconnect(w.plot.set_visible_range)
            w.timeline.margins_changed.disconnect(w.plot.set_margins)
            w.plot_stack.removeWidget(old)
            old.deleteLater()
        w.plot = ErrorPlot(title=title, unit="deg")
        if threshold is not None:
            w.plot.set_threshold(threshold)
        w.plot.frame_requested.connect(self._go_to)
        w.plot.threshold_changed.connect(self.threshold_moved)
        w.plot.visible_range_changed.connect(w.timeline.set_visible_range)
        w.timeline.visible_range_changed.connect(w.plot.set_visible_range)
        w.timeline.margins_changed.connect(w.plot.set_margins)
        w.plot.set_margins(*w.timeline.margins)
        w.plot.set_frame(w.document.frame)
        w.plot_stack.insertWidget(0, w.plot)

    # ---- following

    def show_recording(self) -> None:
        """Show another recording, or none."""
        w = self._w
        recording = w.document.recording
        w.grid.set_views(recording.views if recording is not None else ())
        w.rig.show_rig(recording)
        w.scene.begin_anew()
        self._rig_held = False
        w.findings.show_findings(None)
        w.pixel_label.setText("")
        self._highlighted = ""
        self._on_count_changed(w.document.frame_count)
        w.timeline.set_selection(None)
        self._on_selection(None)
        self.show_judgements()
        self.write_title()

    @Slot()
    def write_title(self) -> None:
        """Say in the title which recording and which project are open."""
        w = self._w
        recording, path = w.document.recording, w.project.path
        names = [recording.name] if recording is not None else []
        if recording is not None and path is not None:
            reading = w.project.project is not None and w.project.project.read_only
            names.append(f"{path.name} (reading only)" if reading else path.name)
        w.setWindowTitle(" – ".join([*names, "stereotrack"]))

    def write_status(self) -> None:
        """Say how things are in one line."""
        w = self._w
        tasks = w.tasks.tasks
        doing = "; ".join(task.says() for task in tasks)
        w.state_label.setText(status_words(w.document, w.track, w.runs, w.judging, doing))
        working = bool(tasks)
        w.cancel_button.setVisible(working)
        w.progress.setVisible(working or w.track.entry is not None)
        entry = w.track.entry
        if working:
            share = tasks[0].share
            w.progress.setRange(0, 100 if share else 0)
            w.progress.setValue(round(100 * share))
        elif entry is not None:
            preparing = w.track.running and not entry.frames
            w.progress.setRange(0, 0 if preparing else len(entry.wanted))
            w.progress.setValue(len(entry.frames))
        drawing = w.inside.drawing
        if drawing is not None and drawing.frame == w.document.frame:
            w.state_label.setText(f"inside frame {drawing.frame}: {drawing.words}")

    @Slot()
    def show_judgements(self) -> None:
        """Curves, lanes, runs and numbers of the runs as they are now."""
        w = self._w
        recording = w.document.recording
        judgement = w.judging.of(w.runs.active)
        if judgement is not None:
            self._make_plot(judgement.words)
            w.plot.set_heading(*heading_words(judgement))
        w.plot_stack.setCurrentWidget(w.plot if w.judging.all() else w.no_curves)
        w.plot.set_curves(curves_of(w.runs, w.judging.all(), w.document.frame_count))
        segments = recording.segments if recording is not None else ()
        reference = w.judging.truth.trajectory if w.judging.truth is not None else None
        w.timeline.set_lanes(lanes_of(judgement, w.document.frame_count, segments, reference))
        w.timeline.set_hint(self._hint())
        w.runs_panel.show_rows([w.run_work.row(entry) for entry in w.runs.entries])
        self._show_numbers()
        w.run_work.show_comparison()

    def _hint(self) -> str:
        w = self._w
        if w.document.recording is None:
            return ""
        if not w.clouds.available:
            return "No view of this recording gives depth, so there is nothing to track."
        keys = w.actions_book.shortcut("run")
        return f"A lane for each limb comes here when the tracker runs ({keys})."

    def _show_numbers(self) -> None:
        w = self._w
        active = w.runs.active
        tracked = active.at(w.document.frame) if active is not None else None
        w.numbers.show_rows(number_rows(tracked, w.judging.of(active)))

    @Slot(object)
    def _on_instant(self, instant: Instant) -> None:
        w = self._w
        display = w.grid.display
        w.grid.show_pictures(pictures_of(instant, w.grid.wanted(), display.overlays))
        self._show_scene_soon()
        w.refresh_soon()

    def show_fit(self, fit: ShownFit | None) -> None:
        """Draw the body fitted to the clicks in the scene, while that is annotated."""
        if fit is not self._fit:
            self._fit = fit
            self._show_scene_soon()

    def _show_scene_soon(self) -> None:
        """Draw the scene when the views are painted; while a key is held down, now and then."""
        if not self._scene_timer.isActive():
            self._scene_waits.start()
        if not self._scene_timer.isActive() or self._scene_waits.elapsed() < _SCENE_PATIENCE_MS:
            self._scene_timer.start()

    @Slot()
    def _show_scene(self) -> None:
        w, instant = self._w, self._w.instant.told
        if instant is None or not w.scene.is_seen():
            return
        if w.annotate.annotating.repeat() is not None:  # nobody shall see what is known already
            instant = dataclasses.replace(instant, reference=None, meshes=())
        entry = w.runs.active
        tracked = entry.at(instant.frame_set.index) if entry is not None else None
        ellipsoids: tuple[Ellipsoid, ...] = ()
        if entry is not None and tracked is not None and w.scene.layer_visible("ellipsoids"):
            ellipsoids = ellipsoids_of(entry, tracked)
        w.scene.show_scene(
            scene_of(
                instant, self._meshes(instant), self.point_colour, self._highlighted, ellipsoids,
                dark=current_theme().is_dark,
            )
        )  # fmt: skip

    def _meshes(self, instant: Instant) -> tuple[PartMesh, ...]:
        """The body fitted to clicks while annotating, else the active run's."""
        fit = self._fit if self._w.annotate.active else None
        fits = fit is not None and fit.question.frame == instant.frame_set.index
        return fit.meshes if fit is not None and fits else instant.meshes

    def settled(self) -> bool:
        """Whether everything shown follows the facts."""
        return not self._scene_timer.isActive()

    @Slot(int)
    def _on_frame_changed(self, frame: int) -> None:
        w = self._w
        w.timeline.set_frame(frame)
        w.plot.set_frame(frame)
        w.transport.set_frame(frame)
        self._show_numbers()

    @Slot(int)
    def _on_count_changed(self, count: int) -> None:
        w = self._w
        recording = w.document.recording
        fps = recording.fps if recording is not None else 1.0
        w.timeline.set_range(count, fps)
        w.transport.set_range(count, fps)

    @Slot()
    def show_findings(self) -> None:
        """What looks wrong about the recording, be it by its files or by what is clicked."""
        w = self._w
        known = w.document.findings
        if known is not None:
            known = (*known, *w.annotate.cameras.findings(w.annotate.facts.view_names()))
        w.findings.show_findings(known)
        serious = [f for f in known or () if f.severity != "note"]
        title = TITLES["findings"]
        w.docks["findings"].setWindowTitle(f"{title} ({len(serious)})" if serious else title)

    # ---- what a person does in the panels

    @Slot(int)
    def _go_to(self, frame: int) -> None:
        self._w.document.pause()
        self._w.document.go_to(frame)

    @Slot(object)
    def _on_selection(self, selection: range | None) -> None:
        self._w.tracker.set_selection(selection)
        self._w.run_work.show_comparison()
        self._w.refresh_soon()

    @Slot(str)
    def highlight(self, limb: str) -> None:
        """Select a limb everywhere; the same again, or none, selects nothing."""
        self._highlighted = "" if limb == self._highlighted else limb
        self.change_display(highlighted=self._highlighted)
        self._w.scene.set_highlighted(self._highlighted)

    def change_display(self, **changes: Any) -> None:
        """Change how pictures are displayed."""
        w = self._w
        w.grid.set_display(dataclasses.replace(w.grid.display, **changes))
        w.instant.tell_soon()

    @Slot(float, float)
    def _on_light(self, brightness: float, contrast: float) -> None:
        self._w.grid.set_light(brightness, contrast, self._w.display_panel.view)

    @Slot(str)
    def _show_light(self, view: str) -> None:
        self._w.display_panel.show_light(view, *self._w.grid.light(view))

    def colour_points(self, kind: PointColour) -> None:
        """Colour the scene's points in another way."""
        self.point_colour = kind
        self._w.instant.tell_soon()

    @Slot(object)
    def use_settings(self, settings: Any) -> None:
        """Use these settings for the next run or step."""
        w = self._w
        w.track.settings = settings
        w.clouds.set_parameters(settings.depth)
        w.instant.tell_soon()
        w.refresh_soon()

    def show_settings(self) -> None:
        """Show the settings of the next run or step."""
        track = self._w.track
        self._w.parameters.set_settings(track.settings, track.base)
        self._w.parameters.set_preset(track.preset)
        self._w.clouds.set_parameters(track.settings.depth)

    def on_run_finished(self, entry: Any) -> None:
        """Say in the status line how a run has ended."""
        judgement = self._w.judging.of(entry)
        score = score_words(judgement)
        known = judgement is not None and judgement.measure == "error"
        whose = "off by" if known else "judged by the filter alone,"
        arms = f", arms {whose} {score} in the median" if score else ""
        frames = counted(len(entry.frames), "frame")
        self._w.statusBar().showMessage(f"{entry.name}: {frames} tracked{arms}.", 8000)
