"""Written by ``tools/fit_lost_limbs.py``: coefficients of upper arms and of forearms."""

RESTS_ON = (
    "one: 7 runs of depth-A, depth-B, depth-C, one-A; 2280 segments, 781 lost",
    "several: 21 runs of depth-A, depth-B, depth-C, four-A, four-B, one-A, two-A, two-B; 5800",
    "segments, 1054 lost",
)
"""Recordings and arm segments; each with the detector's keypoints and without."""

CONSTANTS = {
    "one": (-3.4905, -3.6218),
    "several": (-5.6081, -5.8747),
}
"""By the number of views that see the person."""

SLOPES = {
    "one": {
        "through": (0.0000, 0.8637, 0.0000, 0.0000),
        "behind": (2.0664, 1.5269, 0.0000, 3.4910),
        "visible": (-0.6867, -1.4921, -1.9801, -0.3797),
        "unexplained": (0.3493, 2.1143, 0.6296, 0.7014),
        "jump": (0.0000, 0.0000, 0.0000, 0.0796),
        "buried": (8.2296, 0.0000, 0.0000, 7.1905),
        "better": (3.0483, 4.6028, 0.0000, 1.5910),
        "disagreement": (5.7330, 8.5776, 2.7899, 1.4847),
        "detected": (-2.8648, -3.0670, -1.9688, -1.1869),
    },
    "several": {
        "through": (1.4446, 0.0000, 0.0000, 0.0000),
        "behind": (0.0000, 1.5512, 0.0000, 0.6405),
        "visible": (-1.3191, -0.1872, -1.2719, -0.9432),
        "unexplained": (0.0000, 4.5693, 2.1209, 0.0000),
        "jump": (0.6025, 0.6515, 0.0000, 0.0000),
        "buried": (14.4908, 7.9164, 0.0000, 16.5151),
        "better": (3.8847, 6.1200, 0.0000, 0.4938),
        "disagreement": (8.4687, 13.1821, 2.9769, 2.7227),
        "detected": (-3.1534, -4.0325, -2.8071, -1.9083),
    },
}
"""By views and feature: upper arm and forearm, by their own value and by their neighbour's."""
