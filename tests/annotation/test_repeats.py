"""Repeats are woven in at the share that was asked for, long enough after the first time."""

from __future__ import annotations

from stereotrack_core.annotation.agreement import next_repeat


def annotate(count: int, share: float, apart: int, seed: int = 0) -> list[tuple[int, int]]:
    """Repeated frames, each with the number of frames done by then."""
    done: list[int] = []
    repeats: list[tuple[int, int]] = []
    for frame in range(0, 5 * count, 5):
        done.append(frame)
        again = next_repeat(done, [one for one, _ in repeats], share, apart=apart, seed=seed)
        if again is not None:
            repeats.append((again, len(done)))
    return repeats


def test_the_share_is_kept_and_every_frame_is_repeated_once():
    repeats = annotate(400, 0.05, 20)
    assert len(repeats) == 20
    assert len({frame for frame, _ in repeats}) == 20


def test_nothing_is_repeated_that_was_annotated_just_now():
    for frame, done in annotate(200, 0.5, 20):
        assert frame // 5 < done - 20
