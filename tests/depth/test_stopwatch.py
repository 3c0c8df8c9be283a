import time

from stereotrack_core.depth.view_chain import Stopwatch


def test_laps_of_one_stage_are_added_up():
    begun, watch = time.perf_counter(), Stopwatch()
    for _ in range(3):
        watch.lap("match")
        watch.lap("points")
    assert set(watch.seconds) == {"match", "points"}
    assert 0.0 < sum(watch.seconds.values()) <= time.perf_counter() - begun
