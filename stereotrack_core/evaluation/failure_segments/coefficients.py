"""Written by ``tools/fit_failures.py``: a constant, a slope per sign."""

UPPER_ARM = (
    -2.0406,  # constant
    0.4993,  # turned before
    0.3209,  # turns after
    0.1009,  # lost around
    0.2777,  # lost most around
    0.6577,  # lost of the neighbour
)

UPPER_ARM_WITHOUT_LOST = (
    -4.8984,  # constant
    0.5679,  # turned before
    0.5482,  # turns after
    0.0000,  # sigma
    0.0000,  # sigma around
    2.2725,  # unexplained
    0.3991,  # residual more than usual
)

FOREARM = (
    -1.7078,  # constant
    0.3956,  # turned before
    0.3237,  # turns after
    0.6368,  # lost around
    0.2831,  # lost most around
    0.1018,  # lost of the neighbour
)

FOREARM_WITHOUT_LOST = (
    -6.6745,  # constant
    0.5927,  # turned before
    0.5150,  # turns after
    0.0918,  # sigma
    0.5567,  # sigma around
    2.9733,  # unexplained
    0.6206,  # residual more than usual
)
