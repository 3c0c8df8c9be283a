"""``--quiet`` and ``--verbose``, and what a shell completes."""

import subprocess

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
    path = tmp_path / "a.bvh"
    told = run("export", tracked, "-o", path, "--verbose").err
    assert told.count(f"read: {tracked}\n") == 1
    assert f"written: {path}\n" in told
    assert "numpy" in told
    assert told.splitlines()[-1].startswith("export: ")
    assert "read: " not in run("export", tracked, "-o", path).err
    both = run("-v", "export", tracked, "-o", path, "-q")
    assert (both.status, "quiet and verbose" in both.err) == (2, True)


def test_they_reach_the_commands_of_commands(run, tmp_path):
    ended = run("--verbose", "project", "create", tmp_path)
    assert "numpy" in ended.err
    assert run("project", "--verbose", "create", tmp_path).err == ended.err
    assert run("project", "create", "--verbose", tmp_path).err == ended.err


def test_a_shell_completes_commands_options_and_choices(run, tmp_path):
    pytest.importorskip("shtab")
    ended = run("completion", "bash")
    assert ended.status == 0
    script = tmp_path / "completion.sh"
    script.write_text(ended.out)
    for typed, completed in (
        ("stereotrack tra", "track"),
        ("stereotrack export --form", "--format"),
        ("stereotrack export --format mo", "mot"),
        ("stereotrack import lab", "labels"),
    ):
        words = typed.split()
        ask = (
            f"source {script}; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; "
            '_shtab_stereotrack; echo "${COMPREPLY[@]}"'
        )
        done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True)
        assert done.stdout.split() == [completed]
    assert run("completion", "zsh").out.startswith("#compdef stereotrack")


def test_completion_needs_its_library(run, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "shtab", None)
    ended = run("completion", "bash")
    assert (ended.status, "shtab, which is not installed" in ended.err) == (2, True)
