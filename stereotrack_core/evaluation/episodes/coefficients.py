"""Written by ``tools/fit_episodes.py``: a constant, a slope per sign."""

UPPER_ARM = (
    -2.2115,  # constant
    0.2467,  # lost
    0.4256,  # lost around
    0.2504,  # lost most around
    0.2232,  # lost of the neighbour
    0.0000,  # lost of the other arm
    -0.0668,  # sigma
    0.2300,  # sigma around
    0.0000,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.0000,  # residual
    0.0000,  # near the other arm
    0.0000,  # near the torso
    0.0000,  # turn
    0.0000,  # turn most around
    0.4411,  # jerk most around
)

UPPER_ARM_WITHOUT_LOST = (
    -6.2924,  # constant
    0.0000,  # lost
    0.0000,  # lost around
    0.0000,  # lost most around
    0.0000,  # lost of the neighbour
    0.0000,  # lost of the other arm
    0.1675,  # sigma
    0.1873,  # sigma around
    1.2662,  # unexplained
    5.3452,  # unexplained more than usual
    -0.6783,  # innovation
    -0.4566,  # residual
    -0.6259,  # near the other arm
    3.7140,  # near the torso
    -0.0183,  # turn
    0.1523,  # turn most around
    0.5736,  # jerk most around
)

FOREARM = (
    -0.1239,  # constant
    0.2807,  # lost
    0.5778,  # lost around
    0.2341,  # lost most around
    0.1837,  # lost of the neighbour
    0.0000,  # lost of the other arm
    -0.1589,  # sigma
    -0.0333,  # sigma around
    0.0000,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.0000,  # residual
    0.0000,  # near the other arm
    0.0000,  # near the torso
    0.0000,  # turn
    0.0000,  # turn most around
    0.2797,  # jerk most around
)

FOREARM_WITHOUT_LOST = (
    -7.7933,  # constant
    0.0000,  # lost
    0.0000,  # lost around
    0.0000,  # lost most around
    0.0000,  # lost of the neighbour
    0.0000,  # lost of the other arm
    0.3464,  # sigma
    0.5515,  # sigma around
    5.6605,  # unexplained
    3.8877,  # unexplained more than usual
    -0.5401,  # innovation
    1.4262,  # residual
    -0.1195,  # near the other arm
    3.0879,  # near the torso
    -0.0355,  # turn
    0.1646,  # turn most around
    0.3742,  # jerk most around
)
