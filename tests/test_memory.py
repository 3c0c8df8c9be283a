"""What is kept, and what goes first."""

from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.memory import Memory


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


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 40)), max_size=40))
def test_the_limit_is_never_exceeded_and_bytes_are_counted_right(puts):
    memory, sizes = Memory(60), {}
    memory.hold(lambda key: key < 2)
    for key, size in puts:
        memory.put(key, size, size)
        sizes[key] = size
        assert memory.bytes <= 60
        assert memory.bytes == sum(sizes[k] for k in sizes if k in memory)
