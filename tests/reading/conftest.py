"""What the tests of readers share."""

import mmap
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.reading.catalogue import readers
from tests.reading.more_files import NEEDED
from tests.reading.samples import made_samples


@pytest.fixture(scope="session")
def samples(tmp_path_factory):
    """A recording in which nothing is wrong, a run, a reference and clicks."""
    return made_samples(tmp_path_factory.mktemp("recording"))


@pytest.fixture(scope="session")
def catalogue(samples, tmp_path_factory):
    """Every reader by its name."""
    return readers(samples, tmp_path_factory.mktemp("files"))


@pytest.fixture
def reader(name, catalogue):
    """The reader of that name."""
    if name in NEEDED:
        pytest.importorskip(NEEDED[name])
    return catalogue[name]


@pytest.fixture
def little_memory():
    """A context with 200 MB more than there are before it: what takes them fails."""
    resource = pytest.importorskip("resource")
    if not Path("/proc/self/statm").is_file():
        pytest.skip("memory is read from /proc")

    @contextmanager
    def limited():
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        before = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (pages * mmap.PAGESIZE + (200 << 20), before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_AS, before)

    return limited
