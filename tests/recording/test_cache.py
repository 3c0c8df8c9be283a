"""The cache never holds more bytes than it may, and gives up what was not used longest."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.recording.cache import PictureCache


def picture(size):
    return np.zeros(size, np.uint8)


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 60)), max_size=60))
def test_the_limit_holds_and_the_bytes_are_counted(puts):
    cache = PictureCache(100)
    for k, size in puts:
        cache.put(("N", k), picture(size))
        kept = [p.nbytes for n in range(10) if (p := cache.get(("N", n))) is not None]
        assert cache.bytes_used == sum(kept) <= 100


def test_what_was_used_last_stays():
    cache = PictureCache(30)
    for k in range(3):
        cache.put(("N", k), picture(10))
    assert cache.get(("N", 0)) is not None
    cache.put(("N", 3), picture(10))
    assert [("N", k) in cache for k in range(4)] == [True, False, True, True]


def test_what_is_too_large_is_not_kept_and_drives_nothing_out():
    cache = PictureCache(30)
    cache.put(("N", 0), picture(30))
    cache.put(("N", 1), picture(31))
    assert [("N", k) in cache for k in range(2)] == [True, False]
    cache.clear()
    assert cache.bytes_used == 0
    assert cache.get(("N", 0)) is None
