"""Lengths of a person's body, complete: measured where measured, average elsewhere."""

from dataclasses import dataclass

from stereotrack_core.recording.description import Subject


@dataclass(frozen=True)
class Proportions:
    """Lengths in metres between joint centres."""

    shoulder_width: float = 0.363
    hip_width: float = 0.228  # like it, between the joint centres of both sides
    torso_length: float = 0.461  # hip midpoint to shoulder midpoint
    upper_arm_length: float = 0.272
    forearm_length: float = 0.252  # shoulder to elbow, elbow to wrist
    hand_length: float = 0.194  # wrist to the tip of the middle finger
    shoulder_to_head: float = 0.205  # shoulder midpoint to the head landmark

    @property
    def elbow_to_hand(self) -> float:
        """Elbow to the hand landmark, which lies half way along the hand."""
        return self.forearm_length + 0.5 * self.hand_length

    @property
    def thigh_length(self) -> float:
        """Hip to knee; not measured by a subject's file, taken from :attr:`hip_to_head`."""
        return 0.644 * self.hip_to_head

    @property
    def shank_length(self) -> float:
        """Knee to sole; not measured by a subject's file, taken from :attr:`hip_to_head`."""
        return 0.727 * self.hip_to_head

    @property
    def height(self) -> float:
        """Height of somebody with these lengths, by the average ratios."""
        return AVERAGE_HEIGHT * self.hip_to_head / AVERAGE.hip_to_head

    @property
    def hip_to_head(self) -> float:
        """Hip midpoint to head: unlike the torso alone, the same wherever shoulders are put."""
        return self.torso_length + self.shoulder_to_head

    @property
    def scale(self) -> float:
        """Size of this body against the average one, by its torso and arm lengths."""
        average = AVERAGE
        own = self.torso_length + self.upper_arm_length + self.forearm_length
        return own / (average.torso_length + average.upper_arm_length + average.forearm_length)


AVERAGE_HEIGHT = 1.75  # metres
AVERAGE = Proportions()  # of that height: ratios of common anthropometric tables


def measured(subject: Subject | None) -> bool:
    """Whether any of a subject's lengths is known."""
    return subject is not None and any(getattr(subject, name) is not None for name in vars(AVERAGE))


def proportions_of(subject: Subject | None) -> Proportions:
    """The subject's lengths; missing ones are average ones scaled by those that are known."""
    if subject is None:
        return AVERAGE
    average = vars(AVERAGE)
    known = {name: own for name in average if (own := getattr(subject, name)) is not None}
    scale = sum(known.values()) / sum(average[name] for name in known) if known else 1.0
    return Proportions(**{name: known.get(name, scale * own) for name, own in average.items()})
