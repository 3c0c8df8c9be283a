"""Motions of data sets about everyday actions and sports: sitting, squats, boxing, jogging."""

from stereotrack_core.simulation.postures import Arm, Motion, Posture, keyed

_STANDING = Posture()


def _sit() -> Motion:
    """Sit down as on a chair, hands on the thighs and beside them, and stand up."""
    ahead = Arm((0.10, 0.62, -0.62), (0.6, -0.4, -1.0))
    lap = Arm((-0.02, 0.56, -0.60), (0.9, -0.6, -0.6), bend=4.0)
    beside = Arm((0.24, 0.20, -0.88), (0.4, -1.0, 0.0), bend=6.0)
    going = Posture(ahead, ahead, (20.0, 6.0, 6.0), nod=-4.0, drop=0.24, back=0.24)
    seated = Posture(lap, lap, (6.0, 4.0, 2.0), drop=0.44, back=0.44)
    hanging = Posture(beside, beside, (4.0, 4.0, 4.0), drop=0.44, back=0.44, look=12.0)
    return keyed(
        (0.3, _STANDING), (0.8, going), (0.7, seated), (0.5, seated), (0.7, hanging),
        (0.6, seated), (0.7, going), (0.8, _STANDING),
    )  # fmt: skip


def _squat() -> Motion:
    """Two squats with both arms stretched forward."""
    ahead = Arm((0.02, 0.96, 0.02), (0.4, 0.0, -1.0))
    down = Posture(ahead, ahead, (24.0, 8.0, 4.0), nod=-10.0, drop=0.38, back=0.22)
    up = Posture(ahead, ahead, drop=0.04)
    return keyed(
        (0.2, _STANDING), (0.8, up), (0.7, down), (0.3, down), (0.7, up), (0.7, down),
        (0.7, up), (0.8, _STANDING),
    )  # fmt: skip


def _box() -> Motion:
    """Left and right punches from a guard in front of the chin."""
    guard = Arm((-0.16, 0.46, 0.16), (0.5, -0.1, -1.0))
    left, right = Arm((-0.22, 0.94, 0.10), (0.7, 0.0, -0.8)), Arm((-0.24, 0.92, 0.08))
    ready = Posture(guard, guard, (2.0, 4.0, 4.0), nod=6.0, drop=0.05)
    jab = Posture(left, guard, (3.0, 4.0, 4.0), twist=-12.0, nod=6.0, drop=0.06)
    cross = Posture(guard, right, (3.0, 4.0, 4.0), twist=16.0, nod=6.0, drop=0.06)
    punches = [(0.35, jab), (0.35, ready), (0.35, cross), (0.35, ready)]
    return keyed((0.2, _STANDING), (0.7, ready), *punches * 2, (0.8, _STANDING))


def _jog() -> Motion:
    """Bent arms swing as of a jogger; the feet stay."""
    fore = Arm((0.06, 0.42, -0.34), (0.3, -1.0, -0.5))
    aft = Arm((0.20, -0.06, -0.60), (0.4, -1.0, -0.1))
    one = Posture(fore, aft, (4.0, 3.0, 3.0), twist=-8.0, drop=0.03)
    other = Posture(aft, fore, (4.0, 3.0, 3.0), twist=8.0, drop=0.05)
    return keyed((0.2, _STANDING), (0.6, one), *[(0.4, other), (0.4, one)] * 3, (0.6, _STANDING))


def _clap() -> Motion:
    """Hands together in front of the chest and apart again."""
    out = (0.7, -0.3, -1.0)
    apart = Posture(Arm((0.30, 0.60, -0.20), out), Arm((0.30, 0.60, -0.20), out))
    together = Posture(Arm((-0.27, 0.58, -0.24), out), Arm((-0.27, 0.58, -0.24), out))
    claps = [(0.35, together), (0.35, apart)]
    return keyed((0.2, _STANDING), (0.8, apart), *claps * 3, (0.8, _STANDING))


def _wave() -> Motion:
    """The right hand waves beside the head."""
    inner, outer = Arm((0.06, 0.34, 0.52), (0.8, 0.0, -1.0)), Arm((0.52, 0.30, 0.42), (0.8, 0, -1))
    waves = [(0.35, Posture(right=outer)), (0.35, Posture(right=inner))]
    return keyed((0.2, _STANDING), (0.8, Posture(right=inner)), *waves * 3, (0.8, _STANDING))


def _throw() -> Motion:
    """The right arm winds up beside the head and throws forwards."""
    wound = Arm((0.42, -0.14, 0.52), (0.8, 0.2, -0.6), bend=-8.0)
    released = Arm((0.04, 0.94, 0.12), (0.8, 0.0, -0.8))
    ended = Arm((-0.30, 0.66, -0.50), (0.8, -0.1, -0.8))
    return keyed(
        (0.2, _STANDING),
        (0.8, Posture(right=wound, lean=(-2.0, -3.0, -3.0), twist=-14.0)),
        (0.5, Posture(right=released, lean=(6.0, 4.0, 4.0), twist=12.0, drop=0.04)),
        (0.4, Posture(right=ended, lean=(8.0, 5.0, 5.0), twist=18.0, drop=0.05)),
        (0.9, _STANDING),
    )


EXERCISES: dict[str, Motion] = {
    "sit": _sit(), "squat": _squat(), "box": _box(), "jog": _jog(),
    "clap": _clap(), "wave": _wave(), "throw": _throw(),
}  # fmt: skip
