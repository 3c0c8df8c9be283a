"""Written by ``tools/fit_lost_limbs.py``: a constant, a slope per sign."""

UPPER_ARM = (
    -5.5167,  # constant
    0.4374,  # through
    -0.2131,  # behind
    -3.8880,  # before
    -0.9042,  # unknown
    0.6448,  # worst
    -1.8334,  # visible
    -0.4410,  # agreed
    0.0361,  # neighbour
    1.9610,  # unexplained
    0.7960,  # sigma
    0.0658,  # residual
    0.0202,  # data
    -0.5208,  # jump
    0.4737,  # unexplained fraction
    12.5730,  # buried
    0.3197,  # crossed
    2.0746,  # better
    -0.0892,  # ambiguous
    -0.0068,  # through of the neighbour
    0.2339,  # behind of the neighbour
    -9.5063,  # before of the neighbour
    -2.2936,  # unknown of the neighbour
    -1.0946,  # worst of the neighbour
    1.0971,  # visible of the neighbour
    -0.3732,  # agreed of the neighbour
    0.4014,  # neighbour of the neighbour
    0.2695,  # unexplained of the neighbour
    -1.0326,  # sigma of the neighbour
    -0.0600,  # residual of the neighbour
    -0.3645,  # data of the neighbour
    0.5157,  # jump of the neighbour
    0.4737,  # unexplained fraction of the neighbour
    5.4092,  # buried of the neighbour
    0.0405,  # crossed of the neighbour
    3.6882,  # better of the neighbour
    -0.2347,  # ambiguous of the neighbour
)

FOREARM = (
    -1.7251,  # constant
    -0.0542,  # through
    3.1379,  # behind
    -2.1841,  # before
    -0.0715,  # unknown
    -0.1240,  # worst
    -0.7378,  # visible
    0.2023,  # agreed
    -0.3004,  # neighbour
    2.9195,  # unexplained
    -0.6672,  # sigma
    0.1818,  # residual
    -0.6413,  # data
    -0.0247,  # jump
    -1.1275,  # unexplained fraction
    10.1107,  # buried
    0.0046,  # crossed
    2.2782,  # better
    0.3839,  # ambiguous
    0.1746,  # through of the neighbour
    -2.4900,  # behind of the neighbour
    -2.5459,  # before of the neighbour
    0.5475,  # unknown of the neighbour
    1.6740,  # worst of the neighbour
    -1.2303,  # visible of the neighbour
    -0.0723,  # agreed of the neighbour
    0.5245,  # neighbour of the neighbour
    -0.3271,  # unexplained of the neighbour
    -0.3960,  # sigma of the neighbour
    -0.0133,  # residual of the neighbour
    -0.0290,  # data of the neighbour
    0.0001,  # jump of the neighbour
    -1.1275,  # unexplained fraction of the neighbour
    1.3592,  # buried of the neighbour
    0.9063,  # crossed of the neighbour
    -2.7157,  # better of the neighbour
    0.2902,  # ambiguous of the neighbour
)
