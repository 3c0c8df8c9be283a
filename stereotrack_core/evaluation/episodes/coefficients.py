"""Written by ``tools/fit_episodes.py``: a constant, a slope per sign."""

UPPER_ARM = (
    -3.3326,  # constant
    0.0838,  # lost around
    0.2612,  # lost most around
    0.6225,  # lost of the neighbour
    0.6222,  # turned before
    0.6401,  # turns after
    0.0000,  # sigma
    0.0000,  # sigma around
    0.0000,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.0000,  # residual
)

UPPER_ARM_WITHOUT_LOST = (
    -6.2965,  # constant
    0.0000,  # lost around
    0.0000,  # lost most around
    0.0000,  # lost of the neighbour
    0.8242,  # turned before
    0.9146,  # turns after
    0.0000,  # sigma
    0.0000,  # sigma around
    1.5077,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.4356,  # residual
)

FOREARM = (
    -2.5579,  # constant
    0.5838,  # lost around
    0.2991,  # lost most around
    0.0854,  # lost of the neighbour
    0.4524,  # turned before
    0.5210,  # turns after
    0.0000,  # sigma
    0.0000,  # sigma around
    0.0000,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.0000,  # residual
)

FOREARM_WITHOUT_LOST = (
    -6.7506,  # constant
    0.0000,  # lost around
    0.0000,  # lost most around
    0.0000,  # lost of the neighbour
    0.7351,  # turned before
    0.7572,  # turns after
    0.0272,  # sigma
    0.3476,  # sigma around
    2.0463,  # unexplained
    0.0000,  # unexplained more than usual
    0.0000,  # innovation
    0.6866,  # residual
)
