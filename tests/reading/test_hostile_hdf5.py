"""HDF5 files that take all memory or end the process that reads them."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.hdf5 import is_hdf5
from tests.reading.more_files import OF_HDF5

NEEDED = {"SLEAP": "sleap_io", **dict.fromkeys(OF_HDF5, "h5py")}
LARGE = 400_000_000
"""Rows that are stated and have no byte in the file: 20 GB."""


@pytest.fixture
def reader(name, catalogue):
    pytest.importorskip(NEEDED[name])
    return catalogue[name]


def changed(content: bytes, change) -> bytes:
    import h5py

    file = io.BytesIO(content)
    with h5py.File(file, "r+") as stored:
        change(stored)
    return file.getvalue()


def without_end(stored) -> None:
    """People of SLEAP whose rows are stated only."""
    kind = stored["instances"].dtype
    del stored["instances"]
    stored.create_dataset("instances", shape=(LARGE,), chunks=(1000,), dtype=kind)


def refusal_of(reader, content: bytes, folder: Path) -> InputError:
    (folder / reader.file).write_bytes(content)
    with pytest.raises(InputError) as refusal:
        reader.read(folder / reader.file)
    assert refusal.value.remedy
    assert refusal.value.where.startswith(str(folder))
    return refusal.value


@pytest.mark.skipif(sys.platform != "linux", reason="memory is not limited there")
@pytest.mark.parametrize("name", ["SLEAP"])
def test_rows_without_end_do_not_take_the_memory(reader, tmp_path):
    content = changed(reader.content, without_end)
    assert len(content) < 200_000
    assert "too large for the memory" in refusal_of(reader, content, tmp_path).what


@pytest.mark.parametrize("name", NEEDED)
def test_no_process_is_started_for_what_is_no_hdf5(reader, tmp_path, monkeypatch):
    monkeypatch.setattr("subprocess.Popen", None)
    assert refusal_of(reader, b"no labels", tmp_path).what.startswith("this is not a ")
    assert refusal_of(reader, b"", tmp_path).what.startswith("this is not a ")


def test_a_signature_may_come_later(tmp_path):
    path = tmp_path / "file"
    for before, content in ((0, True), (512, True), (2048, True), (100, False), (1536, False)):
        path.write_bytes(os.urandom(1) * before + b"\x89HDF\r\n\x1a\n" + bytes(3000))
        assert is_hdf5(path) == content
