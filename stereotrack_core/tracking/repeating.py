"""A run again, from what it says about itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.pose_model.installation import detector_versions, is_installed
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.detections import OWN_FILE, own_detections
from stereotrack_core.recording.folder import calibration_fingerprint, fingerprint
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.tracking.frame import DETECTED_SCENES, Run
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import pose_of_values, subject_of_meta
from stereotrack_core.versions import versions

UNSTATED = "pose"  # first pose of a run that began with one that it does not state
_AGAIN = "Track the recording again with this version."

RETRACKED = "retracked"  # key in a run's meta: stretches that were tracked again


@dataclass(frozen=True, eq=False)
class StoredSpec:
    """What a run says about how it was made."""

    spec: RunSpec  # `init` is :data:`UNSTATED` if the run does not state its first pose
    count: int  # how many of the frames were tracked; fewer where the run was stopped
    subject: Subject | None  # whose body was tracked
    # Sources, fingerprint and count of keypoints; `spec` holds them unless an older version made
    # it.
    keypoints: Mapping[str, Any] | None = None
    clicks: Mapping[str, Any] | None = None  # the same of clicks; `spec` is without them
    retracked: bool = False  # whether stretches were tracked again around clicks

    @property
    def states_first_pose(self) -> bool:
        """Whether it is known how the run began."""
        return not isinstance(self.spec.init, str) or self.spec.init != UNSTATED

    def keypoints_or_stored(self, given: Keypoints | None) -> tuple[Keypoints | None, str]:
        """Keypoints, and a sentence if others were used; InputError if they are lacking."""
        if given is None and self.spec.keypoints is not None:
            return self.spec.keypoints, ""
        if self.keypoints is None:
            return given, "" if given is None else "The run did not use keypoints."
        if given is None:
            raise InputError(
                f"the run used keypoints of {', '.join(self.keypoints.get('sources', []))}",
                where="--keypoints",
                remedy="Give them again with `stereotrack track --keypoints`.",
            )
        used = dataclasses.replace(self.spec, keypoints=given).used_keypoints
        prints = {one.fingerprint() for one in (given, used) if one is not None}
        same = self.keypoints.get("fingerprint") in prints
        return given, "" if same else "The keypoints are not those that the run used."

    @property
    def holds_detected(self) -> bool:
        """Whether `spec` has what the pose detector saw, so that no image is looked at again."""
        used = self.spec.keypoints
        detected = used is not None and set(used.source.tolist()) == {DETECTOR_NAME}
        return detected or self.spec.seen is not None

    def without_keypoints(self) -> StoredSpec:
        """The same for other frames or views, of which the run holds no keypoints."""
        spec = dataclasses.replace(self.spec, seen=None, keypoints=None)
        stated = None if self.holds_detected else self.keypoints
        return dataclasses.replace(self, spec=spec, keypoints=stated)


def stored_spec(run: Run) -> StoredSpec:
    """Read how a run was made; InputError without frames or with another version's parameters."""
    meta = run.meta
    if not (len(run.frame) and meta.get("parameters") and meta.get("frames")):
        raise InputError(
            "the run does not state how it was made", where="meta, parameters", remedy=_AGAIN
        )
    (first, end), pose = meta["frames"], meta.get("first_pose")
    seen = {frame: run.seen(frame) for frame in run.frame.tolist()}
    spec = RunSpec(
        settings=_settings(meta["parameters"]),
        preset=str(meta.get("preset", "")),
        frames=range(int(first), int(end)),
        views=tuple(meta.get("views", ())) or None,
        seed=int(meta.get("seed", 0)),
        init=pose_of_values(pose) if isinstance(pose, dict) else str(meta.get("init", "auto")),
        smooth=bool(meta.get("smoothed", False)),
        colour=meta.get("colour"),
        detector=bool(meta.get("detector") or meta.get(DETECTED_SCENES)),
        keypoints=run.keypoints if meta.get("keypoints") else None,
        seen={frame: found for frame, found in seen.items() if found is not None} or None,
    )
    used = meta.get("keypoints"), meta.get("clicks")
    again = bool(meta.get(RETRACKED))
    return StoredSpec(spec, len(run.frame), subject_of_meta(meta), *used, retracked=again)


def what_differs(run: Run, recording: Recording) -> tuple[str, ...]:
    """Why repeating a run on this recording, by this program, may come out otherwise; sentences."""
    meta, found = run.meta, [*other_files(run, recording)]
    measured = dict(meta.get("parameters") or {}).get("proportions", "individual") == "individual"
    if measured and "subject" in meta and subject_of_meta(meta) != recording.subject:
        found.append("The recording now has a different subject. The subject of the run is used.")
    return (*found, *other_versions(meta))


def other_files(run: Run, recording: Recording) -> tuple[str, ...]:
    """Why this is not the recording that a run was tracked with; sentences."""
    meta, found = run.meta, []
    for key, now, what in (
        ("fingerprint", fingerprint(recording), "recording"),
        ("calibration", calibration_fingerprint(recording), "calibration"),
    ):
        then = str(meta.get(key, "unknown"))
        if then != now:
            found.append(
                f"This is not the {what} that the run was tracked with: its fingerprint is "
                f"{now[:8]}, that of the run {then[:8]}."
            )
    own = own_detections(recording)
    print_now = own.fingerprint() if own else None
    if "detections" in meta and (meta["detections"] or {}).get("fingerprint") != print_now:
        found.append(f"The keypoints in {OWN_FILE} of the recording are not those of the run.")
    if run.keypoints is None or meta.get(DETECTED_SCENES):
        found += missing_detector(meta)
    return tuple(found)


def missing_detector(meta: Mapping[str, Any]) -> tuple[str, ...]:
    """Whether the pose detector that a run was tracked with is not installed; a sentence."""
    if is_installed() or not (meta.get("detector") or meta.get(DETECTED_SCENES)):
        return ()
    return (
        "The run was tracked with the pose detector, which is not installed here: "
        "`stereotrack detector install`.",
    )


def other_versions(meta: Mapping[str, Any]) -> tuple[str, ...]:
    """Whether other programs compute now than when a run was tracked; a sentence."""
    then, now = meta.get("versions", {}), versions() | detector_versions()
    changed = [
        f"{name} {then.get(name, 'unknown')} then, {now.get(name, 'none')} now"
        for name in {**now, **then}
        if then.get(name) != now.get(name)
    ]
    return (f"The versions have changed: {'; '.join(changed)}.",) if changed else ()


def changed_parameters(parameters: Mapping[str, Any], name: str) -> dict[str, tuple[Any, Any]]:
    """Parameters that differ from a preset, if known, as (the preset's value, the value)."""
    if name not in PRESETS:
        return {}
    usual = preset(name).values()
    return {
        key: (usual[key], value)
        for key, value in parameters.items()
        if key in usual and usual[key] != value
    }


def _settings(stored: Mapping[str, Any]) -> Settings:
    differ = sorted({row.name for row in Settings.rows()} ^ set(stored))
    if differ:
        raise InputError(
            f"its parameters are not those of this version: {', '.join(differ)}",
            where="meta, parameters",
            remedy=_AGAIN,
        )
    return Settings().replaced(**stored)
