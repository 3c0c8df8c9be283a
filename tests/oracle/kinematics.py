"""Forward kinematics from the thesis's numbers, with 4 x 4 matrices and elementary rotations."""

import functools
import math

import numpy as np


def turn(axis, angle):
    """Homogeneous active right-handed rotation about x, y or z."""
    c, s = math.cos(angle), math.sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    result = np.eye(4)
    result[:3, :3] = rows[axis]
    return result


def shift(x, y, z):
    """Homogeneous translation."""
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def chained(*matrices):
    """Product of homogeneous matrices, from left to right."""
    return functools.reduce(np.matmul, matrices)


def landmarks_of_state(x, p):
    """The nine landmarks by name, of the thesis's 14 numbers and a person's proportions."""
    torso = chained(shift(*x[:3]), turn("z", x[5]), turn("y", x[4]), turn("x", x[3]))
    points = {
        "left_hip": torso @ shift(-p.hip_width / 2, 0, 0),
        "right_hip": torso @ shift(p.hip_width / 2, 0, 0),
        "head": torso @ shift(0, 0, p.torso_length + p.shoulder_to_head),
    }
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    for side, sign, first in (("left", -1, 6), ("right", 1, 10)):
        a, b, c, d = x[first : first + 4]
        upper = chained(down, turn("y", b), turn("x", a))
        fore = chained(turn("y", d), turn("x", c))
        if side == "left":
            upper, fore = chained(mirror, upper, mirror), chained(mirror, fore, mirror)
        shoulder = chained(torso, shift(sign * p.shoulder_width / 2, 0, p.torso_length), upper)
        elbow = chained(shoulder, shift(0, 0, p.upper_arm_length), fore)
        hand = chained(elbow, shift(0, 0, p.forearm_length + p.hand_length / 2))
        points |= {f"{side}_shoulder": shoulder, f"{side}_elbow": elbow, f"{side}_hand": hand}
    return {name: matrix[:3, 3] for name, matrix in points.items()}


def landmarks_of_rotations(position, rotation, proportions):
    """The nine landmarks by name, of a rotation for every part by name."""
    p = proportions

    def turned(part):
        matrix = np.eye(4)
        matrix[:3, :3] = rotation[part]
        return matrix

    torso = chained(shift(*position), turned("torso"))
    neck = chained(torso, shift(0, 0, p.torso_length), turned("head"))
    points = {
        "left_hip": torso @ shift(-p.hip_width / 2, 0, 0),
        "right_hip": torso @ shift(p.hip_width / 2, 0, 0),
        "head": neck @ shift(0, 0, p.shoulder_to_head),
    }
    for side, sign in (("left", -1), ("right", 1)):
        # the clavicle carries the shoulder, whose arm is turned against the torso
        half = p.shoulder_width / 2
        clavicle = chained(torso, shift(sign * 0.12 * half, 0, p.torso_length))
        end = chained(clavicle, turned(f"{side}_clavicle"), shift(0, 0, 0.88 * half))
        carried = np.eye(4)
        carried[:3, :3], carried[:3, 3] = torso[:3, :3], end[:3, 3]
        shoulder = chained(carried, turned(f"{side}_upper_arm"))
        elbow = chained(shoulder, shift(0, 0, p.upper_arm_length), turned(f"{side}_forearm"))
        hand = chained(elbow, shift(0, 0, p.forearm_length + p.hand_length / 2))
        points |= {f"{side}_shoulder": shoulder, f"{side}_elbow": elbow, f"{side}_hand": hand}
    return {name: matrix[:3, 3] for name, matrix in points.items()}
