"""What is kept, and what goes first."""

from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.memory import Memory


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 40)), max_size=40))
def test_the_limit_is_never_exceeded_and_bytes_are_counted_right(puts):
    memory, sizes = Memory(60), {}
    memory.hold(lambda key: key < 2)
    for key, size in puts:
        memory.put(key, size, size)
        sizes[key] = size
        assert memory.bytes <= 60
        assert memory.bytes == sum(sizes[k] for k in sizes if k in memory)
