"""What is kept, and what goes first."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.depth.cloud import ViewDepth
from stereotrack_core.memory import Memory, bytes_of, usual_limit


def test_what_was_not_used_for_longest_goes_first():
    memory = Memory(10)
    for key in "abc":
        memory.put(key, key.upper(), 4 if key == "c" else 3)
    assert memory.get("a") == "A"
    memory.put("d", "D", 3)
    assert [key for key in "abcd" if key in memory] == ["a", "c", "d"]
    assert memory.bytes == 10


def test_what_is_held_stays_and_newcomers_are_not_kept_without_room():
    memory = Memory(10)
    memory.hold(lambda key: key in "ab")
    for key in "abcd":
        memory.put(key, key, 4)
    assert [key for key in "abcd" if key in memory] == ["a", "b"]
    memory.hold(lambda _key: False)
    memory.put("d", "d", 4)
    assert [key for key in "abcd" if key in memory] == ["b", "d"]


def test_what_is_too_large_for_any_room_drives_nothing_out():
    memory = Memory(10)
    memory.put("a", "A", 8)
    memory.put("b", "B", 11)
    assert memory.get("a") == "A"
    assert "b" not in memory


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 40)), max_size=40))
def test_the_limit_is_never_exceeded_and_bytes_are_counted_right(puts):
    memory, sizes = Memory(60), {}
    memory.hold(lambda key: key < 2)
    for key, size in puts:
        memory.put(key, size, size)
        sizes[key] = size
        assert memory.bytes <= 60
        assert memory.bytes == sum(sizes[k] for k in sizes if k in memory)


def test_bytes_of_dataclasses_are_those_of_their_arrays():
    view = ViewDepth(None, None, np.zeros((4, 3), np.float32), np.zeros((4, 3), bool))
    assert bytes_of(view) == 48 + 12
    assert bytes_of({"N": view, "S": view}) == 120
    assert 0 < usual_limit() <= 1024**3
