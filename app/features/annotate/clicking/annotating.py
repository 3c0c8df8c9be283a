"""Which landmark is being clicked, and what a click, a key or a drag does to the project."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

from stereotrack_core.annotation.click import UNCERTAIN, Click, ClickKey, Prediction, Visibility
from stereotrack_core.annotation.doubts import Swap
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project import clicks as click_edits
from stereotrack_core.project.blind_repeats import BlindRepeats
from stereotrack_core.project.edit import Edit, together
from stereotrack_core.project.history import Changed
from stereotrack_core.project.prefilling import accept

from ....context import Context
from ....session.changes import PROJECT, Part
from ....session.edits import Moved
from ....widgets.camera.click_marks import ClickAct
from .choosing import Advance, Annotated, Choice, landmark_at_hand, next_landmark

_CLICKS = frozenset({"click", "repeat_click"})


class Annotating:
    """The clicks of the frame that is shown, the choice, and the edits of both.

    `camera`: name of the camera whose image keys act on, empty if none; `cameras`: of all that are
    shown and take clicks.
    """

    def __init__(
        self, context: Context, camera: Callable[[], str], cameras: Callable[[], Sequence[str]]
    ) -> None:
        session, self._say = context.session, context.notifier.say
        self._changes, self._document, self._project = (
            session.changes, session.document, session.project,
        )  # fmt: skip
        self._camera, self.shown_cameras = camera, cameras
        self.repeats: BlindRepeats | None = None
        self.landmark_set = NINE
        """Landmarks that are clicked in this project."""
        self._facts: tuple[int, dict[ClickKey, Click]] | None = None
        self._unused: frozenset[str] | None = None  # None: to be read
        self._nudged: ClickKey | None = None
        self._untold: Part | None = None
        self._reading = (0, False)
        self.advance: Advance = "landmark"
        self.goes_on = False
        """Whether another frame is shown when this one is clicked in all views."""
        self.choice = Choice(NINE.names[0])
        self._changes.watch(Part.FRAME, self.reread)
        self._changes.hear(Part.EDIT, self._on_changed)
        self._changes.watch(PROJECT, self._on_project)

    # ---- facts

    def clicks(self) -> Mapping[ClickKey, Click]:
        """Clicks of the frame that shall be shown, read once; blindly: those of this reading."""
        frame = self._document.frame
        if self._facts is None or self._facts[0] != frame:
            project, found = self._project.project, tuple[Click, ...]()
            if project is not None:
                clicks = project.clicks
                found = clicks.again_at(frame) if self.blind() else clicks.at(frame)
            self._facts = (frame, {click.key: click for click in found})
        return self._facts[1]

    def used_clicks(self) -> tuple[Click, ...]:
        """The same, without cameras that are left out."""
        unused = self.unused()
        return tuple(one for one in self.clicks().values() if one.camera not in unused)

    def unused(self) -> frozenset[str]:
        """Cameras that are left out of triangulation, fit and export."""
        if self._unused is None:
            project = self._project.project
            self._unused = project.marks.unused_cameras() if project is not None else frozenset()
        return self._unused

    def blind(self) -> bool:
        return self.repeats is not None and self.repeats.active == self._document.frame

    def reread(self) -> None:
        """Read the clicks again; a blind repeat that begins or ends releases the held click."""
        with self._as_one():
            self._facts = None
            reading = (self._document.frame, self.blind())
            if reading != self._reading:
                self._reading = reading
                self._begin_reading()
            self._follow()
            self._tell(Part.CLICKS)

    def at_hand(self) -> Click | None:
        """The click that keys act on: touched last, else the chosen landmark's here."""
        here = ClickKey(self._document.frame, self._camera(), self.choice.landmark)
        clicks = self.clicks()
        return clicks.get(self.choice.touched or here, clicks.get(here))

    def held(self) -> ClickKey | None:
        """The click that Alt+arrows move: the last one, until the frame changes or it is let go."""
        touched = self.choice.touched
        click = self.clicks().get(touched) if touched is not None else None
        return click.key if click is not None and click.position is not None else None

    # ---- choosing

    def next_in(self, camera: str) -> str | None:
        """The landmark that the next click in a camera's image places; None: it places none."""
        return next_landmark(self.choice, self.advance, self._annotated(), camera)

    def follow(self) -> None:
        with self._as_one():
            self._follow()

    def set_advance(self, advance: Advance) -> None:
        self.advance = advance
        with self._as_one():
            self._follow()
            self._tell(Part.CLICKS)

    def choose(self, landmark: str) -> None:
        """Let the next click place this landmark, in whichever image."""
        if landmark in self.landmark_set.names:
            self._choose(Choice(landmark, asked=True))

    def choose_place(self, place: int) -> None:
        self.choose(self.landmark_set.names[place])

    def choose_next(self, by: int) -> None:
        names = self.landmark_set.names
        self.choose(names[(names.index(self.choice.landmark) + by) % len(names)])

    def pick(self, key: ClickKey) -> None:
        """Take a click in hand: keys act on it, Alt+arrows move it."""
        if key in self.clicks():
            self._choose(Choice(key.landmark, key, picked=True))

    def pick_last(self) -> None:
        click = self.at_hand()
        if click is not None and click.position is not None:
            self.pick(click.key)

    def let_go(self) -> None:
        with self._as_one():
            self._choose(Choice(self.choice.landmark))
            self._follow()

    def _annotated(self) -> Annotated:
        clicks, frame = self.clicks(), self._document.frame
        return Annotated(self.landmark_set.names, clicks, frame, self.shown_cameras())

    def _begin_reading(self) -> None:
        """Begin another frame or reading; only a landmark chosen by the person is kept."""
        choice = self.choice
        own = choice.asked or self.advance == "none"
        landmark = choice.landmark if own else self.landmark_set.names[0]
        again = choice.again
        if again is not None and again.frame != self._document.frame:
            again = None
        self._choose(Choice(landmark, asked=choice.asked, again=again))

    def _follow(self) -> None:
        camera = self._camera()
        if not self._is_picked() and camera:
            landmark = landmark_at_hand(self.choice, self.advance, self._annotated(), camera)
            if landmark is not None:
                self._choose(replace(self.choice, landmark=landmark))

    def _is_picked(self) -> bool:
        return self.choice.picked and self.choice.touched in self.clicks()

    def _choose(self, choice: Choice) -> None:
        self._nudged = None
        if choice != self.choice:
            self.choice = choice
            self._tell(Part.CHOICE)

    # ---- edits

    def act(self, act: ClickAct) -> None:
        """Do what a person did with the mouse in a view."""
        match act.what:
            case "move":
                self.move(act.key, act.pixel)
            case "pick":
                self.pick(act.key)
            case _:
                seen = Visibility.GUESSED if act.what == "guess" else Visibility.SEEN
                self.place(act.key, act.pixel, seen)

    def place(
        self,
        key: ClickKey,
        position: tuple[float, float] | None,
        visibility: Visibility = Visibility.SEEN,
    ) -> None:
        """Place a landmark, or say that it is outside the image.

        A click that is there already is moved only if the person has chosen its landmark.
        """
        with self._as_one():
            click = Click(*key, position, visibility)
            before = self._click_of(key)
            if before is not None and not (self.choice.asked or self.advance == "none"):
                label = key.landmark.replace("_", " ")
                self._say(f"The {label} is already clicked here. Drag it to move it.")
                return
            # the same click again changes nothing, and is as good
            same = before is not None and before.says_the_same(click)
            if self._edit(click_edits.place(click)) or same:
                self._advance_from(click.key, new=before is None)

    def _click_of(self, key: ClickKey) -> Click | None:
        """A click by its key, also of a frame that is being left."""
        project = self._project.project
        if key.frame == self._document.frame or project is None:
            return self.clicks().get(key)
        click = project.clicks.get(key)
        return None if click is None or click.deleted else click

    def move(self, key: ClickKey, position: tuple[float, float]) -> None:
        click = self.clicks().get(key)
        if click is not None and click.position is not None:
            by = (position[0] - click.position[0], position[1] - click.position[1])
            with self._as_one():
                self._edit(click_edits.move_clicks((key,), by))
                self.pick(key)

    def nudge(self, x: float, y: float) -> None:
        key = self.held()
        if key is not None:
            again = self._nudged == key
            self._edit(click_edits.move_clicks((key,), (x, y)), continues=again)
            self._nudged = key

    def delete(self) -> None:
        with self._as_one():
            click = self.at_hand()
            if click is not None and self._edit(click_edits.delete_clicks((click.key,))):
                self._choose(Choice(click.landmark, again=click.key))
                self._follow()

    def delete_everywhere(self) -> None:
        with self._as_one():
            click = self.at_hand()
            landmark = click.landmark if click is not None else self.choice.landmark
            keys = tuple(key for key in self.clicks() if key.landmark == landmark)
            if keys and self._edit(click_edits.delete_clicks(keys)):
                self.choose(landmark)

    def mark(self, visibility: Visibility) -> None:
        """Say how a click is seen; outside is what the next click would place, unless picked."""
        with self._as_one():
            if visibility != Visibility.OUTSIDE:
                click = self.at_hand()
                if click is not None:
                    self._edit(click_edits.mark_clicks((click.key,), visibility=visibility))
                return
            key = self.choice.touched if self._is_picked() else None
            if key is None:
                landmark = self.next_in(self._camera())
                if landmark is None:
                    self._say("The landmark is marked as outside. Right-click to select it.")
                    return
                key = ClickKey(self._document.frame, self._camera(), landmark)
            click = self.clicks().get(key)
            if click is None or click.position is None:
                self.place(key, None, Visibility.OUTSIDE)
            elif self._edit(click_edits.mark_clicks((key,), visibility=visibility)):
                self._advance_from(key)

    def toggle_doubt(self) -> None:
        click = self.at_hand()
        if click is not None:
            flag = "" if click.flag == UNCERTAIN else UNCERTAIN
            self._edit(click_edits.mark_clicks((click.key,), flag=flag))

    def set_sigma(self, sigma: float | None) -> None:
        """Say to how many pixels the click that keys act on is good; None: as usual."""
        click = self.at_hand()
        if click is not None:
            keys = (click.key,)
            self._edit(click_edits.mark_clicks(keys, sigma=sigma, usual_sigma=sigma is None))

    def accept(self, predictions: Sequence[Prediction]) -> None:
        """Let predictions be clicks that are certain enough, where nobody has clicked."""
        project, recording = self._project.project, self._document.recording
        free = tuple(one for one in predictions if one.key not in self.clicks())
        if free and project is not None and recording is not None:
            accepted = accept(project, free, recording.cameras)
            taken = accepted.predictions
            with self._as_one():
                if taken and self._edit(
                    click_edits.accept_points(taken, even_deleted=len(free) == 1)
                ):
                    self._advance_from(taken[-1].key, new=True)
            if accepted.left_open:
                self._say(accepted.words())

    def confirm(self, one: Prediction) -> None:
        """Let a prediction be a click that a person has looked at, however uncertain it was."""
        with self._as_one():
            if self._edit(click_edits.accept_points((one,), even_deleted=True)):
                self._advance_from(one.key, new=True)

    def swap(self, found: Swap) -> None:
        """Exchange two landmarks in the cameras where they were mixed up; one edit."""
        frame, first, second = found.frame, found.first, found.second
        edits = [click_edits.swap_landmarks(frame, name, first, second) for name in found.cameras]
        names = f"{first} and {second}".replace("_", " ")
        words = f"swap {names} in {len(edits)} cameras, frame {frame}"
        if edits:
            self._edit(edits[0] if len(edits) == 1 else together(words, tuple(edits)))

    @contextmanager
    def _as_one(self) -> Iterator[None]:
        """Tell all changes within the block at once; new clicks say that the choice may be too."""
        if self._untold is not None:
            yield
            return
        self._untold = Part(0)
        try:
            yield
        finally:
            untold, self._untold = self._untold, None
            if untold:
                self._changes.tell(Part.CLICKS if Part.CLICKS in untold else Part.CHOICE)

    def _tell(self, part: Part) -> None:
        with self._as_one():
            if self._untold is not None:
                self._untold |= part

    def _edit(self, edit: Edit, *, continues: bool = False) -> bool:
        self._nudged = None
        edit = click_edits.blind_repeat(edit) if self.blind() else edit
        return self._project.apply(edit, continues=continues) is not None

    def _advance_from(self, key: ClickKey, *, new: bool = False) -> None:
        """Choose the next landmark, or go to the next frame after a `new` click."""
        stays, annotated = self.advance == "none", self._annotated()
        self._choose(Choice(key.landmark, key, picked=stays))
        if (
            new and self.goes_on and not self.blind()
            and annotated.complete((key.landmark,) if stays else self.landmark_set.names)
        ):  # fmt: skip
            self._go_on()
            return
        following = landmark_at_hand(self.choice, self.advance, annotated, key.camera)
        if following is not None:
            self._choose(replace(self.choice, landmark=following))
        else:
            where = "this" if self.advance == "landmark" else "every"
            self._say(f"Every landmark has a click in {where} view.")

    def rhythm(self) -> Sequence[int]:
        """Frames to be annotated: keyframes that are not done; all where none are set."""
        project = self._project.project
        keyframes = project.marks.keyframes() if project is not None else ()
        wanted = [one.frame for one in keyframes if not one.done]
        return wanted if keyframes else range(self._document.frame_count)

    def following_frame(self) -> int | None:
        """The next frame to be annotated; None: no more."""
        return next((one for one in self.rhythm() if one > self._document.frame), None)

    def _go_on(self) -> None:
        after = self.following_frame()
        if after is None:
            project = self._project.project
            kind = "keyframe" if project is not None and project.marks.keyframes() else "frame"
            self._say(f"Every landmark is clicked in this frame. No {kind} follows.")
        else:
            self._document.visit(after)

    # ---- following

    def _on_changed(self, changed: Changed) -> None:
        if changed.tables & {"choice", "landmark_set"}:
            self._read_set()
        if changed.tables & _CLICKS:
            self._facts = None
        if "camera_use" in changed.tables:
            self._unused = None
        if changed.tables & {*_CLICKS, "choice", "landmark_set"}:
            with self._as_one():
                self._follow()
                self._tell(Part.CLICKS)

    def _on_project(self) -> None:
        project = self._project.project
        self.repeats = BlindRepeats(project) if project is not None else None
        with self._as_one():
            self._facts = self._unused = None
            self._read_set()
            self._tell(Part.CLICKS)

    def end_nudging(self) -> None:
        self._nudged = None

    def choose_moved(self, moved: Moved) -> None:
        changes = () if moved.changed is None else moved.changed.changes
        rows = [change.key[-3:] for change in changes if change.table.name in _CLICKS]
        keys = [ClickKey(int(row[0] or 0), str(row[1]), str(row[2])) for row in rows]
        if len({key.landmark for key in keys}) == 1:
            one = keys[0] if len(keys) == 1 else None
            with self._as_one():
                self._choose(Choice(keys[0].landmark, touched=one, again=one))
                self._follow()

    def _read_set(self) -> None:
        project = self._project.project
        self.landmark_set = project.landmark_set() if project is not None else NINE
        if self.choice.landmark not in self.landmark_set.names:
            self._choose(Choice(self.landmark_set.names[0]))
