"""Written by ``tools/fit_failures.py``: a constant, a slope per sign."""

UPPER_ARM = (
    -2.0406,  # constant
    0.4993,  # turned before
    0.3209,  # turns after
    0.1009,  # lost around
    0.2777,  # lost most around
    0.6577,  # lost of the neighbour
)

FOREARM = (
    -1.7078,  # constant
    0.3956,  # turned before
    0.3237,  # turns after
    0.6368,  # lost around
    0.2831,  # lost most around
    0.1018,  # lost of the neighbour
)
