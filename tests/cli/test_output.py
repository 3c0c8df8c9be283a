"""Results on standard output."""

import io
import json
import sys

import pytest

from stereotrack_core.cli.output import put, put_json, put_table, say
from stereotrack_core.tables import Table


def test_table_is_not_cut_off(capsys):
    long = "a sentence that goes on " * 10
    put_table(Table("Title [x]", ("name", ">value"), [(long, "1.0"), ("[b]", "-")]))
    out = capsys.readouterr().out
    assert "Title [x]" in out
    assert "[b]" in out
    words = " ".join(out.split())
    assert words.count("sentence that") >= 9
    assert "…" not in out
    assert all(line == line.rstrip() for line in out.split("\n"))


HIDDEN = "N\x1b[31m\x07 \x9bm \u202eleft\u2066 \x7f"
SPELLED = "N\\u001b[31m\\u0007 \\u009bm \\u202eleft\\u2066 \\u007f"


@pytest.mark.parametrize("terminal", [False, True])
def test_control_characters_never_reach_the_terminal(monkeypatch, terminal):
    written = io.StringIO()
    written.isatty = lambda: terminal
    monkeypatch.setattr(sys, "stdout", written)
    monkeypatch.setattr(sys, "stderr", written)
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.setenv("TERM", "dumb")  # or the table's own bold letters would need one
    put(HIDDEN)
    say(f"{HIDDEN}\n\tand a second line")
    assert written.getvalue() == f"{SPELLED}\n{SPELLED}\n\tand a second line\n"
    written.seek(0)
    written.truncate()
    put_table(Table(HIDDEN, (HIDDEN, "b"), [(HIDDEN, "1")]))
    shown = written.getvalue()
    assert shown.count(SPELLED) == 3
    assert not {sign for sign in shown if not sign.isprintable()} - {"\n"}


def test_json_keeps_what_it_holds(capsys):
    put_json({HIDDEN: [HIDDEN, "Größe\n"]})
    out = capsys.readouterr().out
    assert json.loads(out) == {HIDDEN: [HIDDEN, "Größe\n"]}
    assert out.replace("\n", "").isprintable()


def test_quiet_says_only_results_and_errors(run, tracked, tmp_path):
    path = tmp_path / "a.bvh"
    said = run("export", tracked, "-o", path)
    quiet = run("export", tracked, "-o", path, "--quiet")
    assert quiet.out == said.out
    assert quiet.err == ""
    assert run("-q", "export", tracked, "-o", path).err == ""
    wrong = run("-q", "export", tracked, "-o", tmp_path / "a.xyz", status=2)
    assert wrong.err.startswith("stereotrack: ")
    assert run("export", tracked, "-o", path).err == said.err
