"""Written by ``tools/fit_episodes.py``: a constant, a slope per sign."""

UPPER_ARM = (
    -2.3336,  # constant
    0.2262,  # lost
    0.4156,  # lost around
    0.2662,  # lost most around
    0.2614,  # lost of the neighbour
    0.0000,  # lost of the other arm
    -0.0683,  # sigma
    0.2599,  # sigma around
    0.0000,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.0000,  # residual
    0.0000,  # near the other arm
    0.0000,  # near the torso
    0.0000,  # turn
    0.0000,  # turn most around
    0.4635,  # jerk most around
)

UPPER_ARM_WITHOUT_LOST = (
    -6.3785,  # constant
    0.0000,  # lost
    0.0000,  # lost around
    0.0000,  # lost most around
    0.0000,  # lost of the neighbour
    0.0000,  # lost of the other arm
    0.1742,  # sigma
    0.2267,  # sigma around
    1.1357,  # unexplained
    6.9139,  # unexplained more than usual
    -0.8378,  # innovation
    -0.7025,  # residual
    -0.5958,  # near the other arm
    3.6887,  # near the torso
    -0.0396,  # turn
    0.1589,  # turn most around
    0.5739,  # jerk most around
)

FOREARM = (
    -0.2199,  # constant
    0.2674,  # lost
    0.5790,  # lost around
    0.2775,  # lost most around
    0.1657,  # lost of the neighbour
    0.0000,  # lost of the other arm
    -0.1624,  # sigma
    -0.0041,  # sigma around
    0.0000,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.0000,  # residual
    0.0000,  # near the other arm
    0.0000,  # near the torso
    0.0000,  # turn
    0.0000,  # turn most around
    0.2683,  # jerk most around
)

FOREARM_WITHOUT_LOST = (
    -7.6372,  # constant
    0.0000,  # lost
    0.0000,  # lost around
    0.0000,  # lost most around
    0.0000,  # lost of the neighbour
    0.0000,  # lost of the other arm
    0.3442,  # sigma
    0.5306,  # sigma around
    5.7024,  # unexplained
    5.2243,  # unexplained more than usual
    -0.5744,  # innovation
    1.1373,  # residual
    -0.0747,  # near the other arm
    3.0651,  # near the torso
    -0.0642,  # turn
    0.1274,  # turn most around
    0.3882,  # jerk most around
)
