"""Written by ``tools/fit_episodes.py``: a constant, a slope per sign."""

UPPER_ARM = (0.0, 1.0) + (0.0,) * 15
FOREARM = (0.0, 1.0) + (0.0,) * 15
UPPER_ARM_WITHOUT_LOST = (-3.0,) + (0.0,) * 16
FOREARM_WITHOUT_LOST = (-3.0,) + (0.0,) * 16
