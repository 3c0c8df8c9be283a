"""``--quiet``."""

import pytest

pytestmark = pytest.mark.xdist_group("cli")


def test_quiet_says_only_results_and_errors(run, tracked, tmp_path):
    path = tmp_path / "a.bvh"
    said = run("export", tracked, "-o", path)
    quiet = run("export", tracked, "-o", path, "--quiet")
    assert (quiet.status, quiet.out) == (0, said.out)
    assert quiet.err == ""
    assert run("-q", "export", tracked, "-o", path).err == ""
    wrong = run("-q", "export", tracked, "-o", tmp_path / "a.xyz")
    assert wrong.err.startswith("stereotrack: ")
    assert run("export", tracked, "-o", path).err == said.err
