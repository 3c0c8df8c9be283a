"""``--quiet`` and ``--verbose``."""

import pytest

pytestmark = pytest.mark.xdist_group("cli")


def test_quiet_says_only_results_and_errors(run, tracked, tmp_path):
    path = tmp_path / "a.mot"
    said = run("export", tracked, "-o", path)
    quiet = run("export", tracked, "-o", path, "--quiet")
    assert (quiet.status, quiet.out) == (0, said.out)
    assert quiet.err == ""
    assert run("-q", "export", tracked, "-o", path).err == ""
    wrong = run("-q", "export", tracked, "-o", tmp_path / "a.xyz")
    assert wrong.err.startswith("stereotrack: ")
    assert run("export", tracked, "-o", path).err == said.err


def test_verbose_tells_files_and_time(run, tracked, tmp_path):
    path = tmp_path / "a.glb"
    told = run("export", tracked, "-o", path, "--verbose").err
    assert told.count(f"read: {tracked}\n") == 1
    assert f"written: {path}\n" in told
    assert "numpy" in told
    assert told.splitlines()[-1].startswith("export: ")
    assert "read: " not in run("export", tracked, "-o", path).err
    both = run("-v", "export", tracked, "-o", path, "-q")
    assert (both.status, "quiet and verbose" in both.err) == (2, True)
