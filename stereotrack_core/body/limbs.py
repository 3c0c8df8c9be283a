"""The limbs that errors, colours and confidences are stated for."""

LIMBS: tuple[str, ...] = (
    "torso",
    "head",
    "left_upper_arm",
    "right_upper_arm",
    "left_forearm",
    "right_forearm",
)
"""Every array over limbs has this order; left and right are the person's own."""
