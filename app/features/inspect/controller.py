"""The steps of the tracker in the frame that is shown: panel, drawing in views and scene."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.mesh import body_mesh
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import limb_of_part
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Correspondences
from stereotrack_core.tracking.trace import (
    HIDDEN,
    INSIDE,
    ON_PARTNER,
    TOO_FAR,
    Correction,
    StepTrace,
)

from ...context import Context
from ...services.actions import Command, Menu
from ...session.changes import Part
from ...session.inspection import Step, name_of
from ...session.session import Session, Snapshot
from ...session.view_state import InsideScene, Marked, StepDrawing
from ...widgets.forms.message import StateBar
from ...widgets.plots.inside_panel import InsidePanel
from ...widgets.style.colours import LIMB_COLOURS, SHADES, shade_colours, shade_of
from .contents import content_of

_SHARE = 0.68  # share of its column that the panel gets while a frame is inspected
_WAITING = "Measuring the points of this frame and recording the tracker's step …"


def register(context: Context) -> InspectController:
    """Offer the panel and its commands."""
    inspect = InspectController(context)
    context.actions.add(_commands(context.session, inspect.toggle))
    names = ("inside_previous", "inside_next", "look_inside")
    actions = [context.actions.action(name) for name in names]
    inspect.panel.set_actions(actions, context.actions.key_words(names[-1]))
    return inspect


def _commands(session: Session, toggle: Callable[[], None]) -> list[Command]:
    inspection, command = session.inspection, Menu("&Track").command
    return [
        command("look_inside", "Inspect step", "Show step by step how the tracker processes this "
                "frame: prediction, points, correspondences, sigma points, cross-covariance, "
                "correction.", toggle, "F12", "search", section=True,
                why_not=lambda: session.not_tried() or session.tracker_works(),
                checked=lambda: inspection.on),
        command("inside_next", "Next stage of the step", "Show the next stage of the tracker's "
                "step.", lambda: inspection.go(inspection.index + 1), "F7", "step-forward",
                why_not=lambda: inspection.why_no_step(1)),
        command("inside_previous", "Previous stage of the step", "Show the previous stage of the "
                "tracker's step.", lambda: inspection.go(inspection.index - 1), "Shift+F7",
                "step-back", why_not=lambda: inspection.why_no_step(-1)),
    ]  # fmt: skip


class InspectController:
    """Shows the stage that is chosen; the views show it too, instead of the run."""

    def __init__(self, context: Context) -> None:
        self._context, self._state = context, context.session.inspection
        self.panel = InsidePanel(
            self._state.go, partial(context.session.changes.tell, Part.PARAMETER_WANTED)
        )
        context.docks.add("inside", "Inspect step", self.panel)
        self.bar = StateBar("Inspect step", "Close", "Stop inspecting and show the run again")
        self.bar.button.clicked.connect(self._state.leave)
        context.docks.below_views.addWidget(self.bar)
        self._drawn: object = None
        context.show(Part.INSPECTION, self._show)

    def toggle(self) -> None:
        if self._state.on:
            self._state.leave()
            return
        self._context.docks.bring_up("inside")
        self._context.session.changes.loop.post(self._make_room)
        self._state.begin()

    def _make_room(self) -> None:
        if self._state.on:
            self._context.docks.make_room("inside", _SHARE)

    def _show(self, now: Snapshot) -> None:
        known, step, panel = self._state.known, self._state.step, self.panel
        if known is None or step is None:
            self._drawn = None
            panel.show_nothing(_WAITING if self._state.on else "")
        else:
            if (known, step) != self._drawn:
                self._drawn = known, step
                drawing = drawing_of(known.done.trace, step, known.done.cloud)
                self._context.view_state.draw(drawing)
            panel.show_steps(known.steps, self._state.index)
            content = content_of(known.done.trace, step, known.compared)
            panel.show_content(content, known.done.words, busy=self._state.busy)
        self.bar.show_words(self._words(now))
        if not self._state.on:
            self._context.docks.give_room_back()
        self._context.actions.refresh_soon()

    def _words(self, now: Snapshot) -> str:
        if not self._state.on:
            return ""
        name = f" of run “{now.active.name}”" if now.active is not None else ""
        frame = now.frame if self._state.known is None else self._state.known.question.frame
        return f"Inspecting the tracker's step in frame {frame}{name}. The views show its stages."


_AROUND = 8
_LEAST_MOVE = 0.002  # metres by which a part of a ghost differs from the model before it is drawn
_LEGS = "#b5b5b5"
_UNUSED = {HIDDEN: "#4d4d4d", INSIDE: "#F0E442", TOO_FAR: "#CC79A7", ON_PARTNER: "#009E73"}
"""Colours of points that are not used, by reason; what is only surplus is not drawn."""


def drawing_of(trace: StepTrace, step: Step, cloud: Cloud) -> StepDrawing:
    """Marks and models that are drawn for one step."""
    pose, scene = _drawn(trace, step)
    return StepDrawing(trace.frame, name_of(step, trace), trace.body, pose, scene, cloud)


def _drawn(trace: StepTrace, step: Step) -> tuple[Pose, InsideScene]:
    correction = trace.corrections[step.correction] if step.correction >= 0 else None
    body = trace.body
    match step.kind:
        case "predict":
            pose = trace.predicted.pose
            return pose, InsideScene(ghosts=_ghosts(body, pose, [trace.before.pose]))
        case "settle" | "result":
            pose = trace.after.pose
            return pose, InsideScene(ghosts=_ghosts(body, pose, [trace.predicted.pose]))
        case "collisions" if trace.jump is not None:
            pose = trace.jump.after
            return pose, InsideScene(ghosts=_ghosts(body, pose, [trace.jump.before]))
        case "search" if trace.search is not None:
            pairs = (trace.search.followed, *trace.search.pairs)
            chosen = next(pair.pose for pair in pairs if pair.chosen)
            others = [pair.pose for pair in pairs if not pair.chosen]
            return chosen, InsideScene(ghosts=_ghosts(body, chosen, others))
        case "pairs" if correction is None:
            return trace.predicted.pose, InsideScene(lines=_pairs(trace.measured[0]))
        case _ if correction is not None:
            return _drawn_of(body, step, correction)
    return trace.after.pose, InsideScene()


def _drawn_of(body: BodyModel, step: Step, correction: Correction) -> tuple[Pose, InsideScene]:
    before, after = correction.before.pose, correction.after.pose
    if step.kind == "points":
        return before, InsideScene(dots=_dots(correction))
    if step.kind == "sigma":
        poses = correction.sigma_points.poses
        others = [poses[i] for i in range(1, len(poses.position))]
        return before, InsideScene(ghosts=_ghosts(body, before, others))
    if step.kind == "correct":
        return after, InsideScene(ghosts=_ghosts(body, after, [before]))
    return before, InsideScene(lines=_pairs(correction.points))


def _dots(correction: Correction) -> tuple[Marked, ...]:
    """Points that are used, by part, and those that are not; sampled ones lie on the model."""
    points, unused = correction.points, correction.unused
    sampled = bool(np.any(unused.part >= 0))
    there = [why for why in _UNUSED if np.any(unused.why == why)]
    marked = [Marked(_UNUSED[why], unused.place[unused.why == why]) for why in there]
    places = points.model if sampled else points.data
    for part in np.unique(points.part).tolist():
        colour = LIMB_COLOURS.get(limb_of_part(part), _LEGS)
        marked.append(Marked(colour, places[points.part == part]))
    return tuple(marked)


def _pairs(points: Correspondences) -> tuple[Marked, ...]:
    """Lines from measured points to the model, by the colour of their residuals."""
    shade, colours = shade_of(points.residual), shade_colours()
    ends = np.stack([points.data, points.model], axis=1)
    return tuple(Marked(colours[k], ends[shade == k]) for k in range(SHADES) if np.any(shade == k))


def _ghosts(body: BodyModel, model: Pose, others: list[Pose]) -> tuple[Marked, ...]:
    """The model in other poses, without the parts that are where the model is."""
    meshes = body_mesh(body, model, around=_AROUND)
    here = body.frames(model)
    positions = np.stack([pose.position for pose in others])
    stacked = body.frames(Pose(positions, np.stack([pose.rotations for pose in others])))
    ghosts = []
    for mesh in meshes:
        part = mesh.part
        local: FloatArray = (mesh.vertices - here.origins[part]) @ here.rotations[part]
        turned = np.einsum("sij,vj->svi", stacked.rotations[:, part], local)
        vertices = turned + stacked.origins[:, part, None]
        off = np.abs(vertices - mesh.vertices).max(axis=(1, 2)) > _LEAST_MOVE
        if off.any():
            ghosts.append(Marked(mesh.limb, vertices[off]))
    return tuple(ghosts)
