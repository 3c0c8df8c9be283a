"""Results on standard output."""

import io
import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.cli.output import put, put_json, put_table, say
from stereotrack_core.plain_data import plain
from stereotrack_core.program import main
from stereotrack_core.tables import Table, number


@dataclass(frozen=True)
class Fact:
    value: float
    place: Path


def test_plain_values():
    value = {
        "a": np.float64("nan"),
        "b": np.array([1.0, np.inf]),
        3: Fact(2.5, Path("x")),
        "c": (np.int64(4), True, None),
    }
    wanted = {"a": None, "b": [1.0, None], "3": {"value": 2.5, "place": "x"}, "c": [4, True, None]}
    assert plain(value) == wanted


def test_json_is_strict(capsys):
    put_json({"nan": float("nan"), "text": "Größe"})
    assert json.loads(capsys.readouterr().out) == {"nan": None, "text": "Größe"}


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


def test_letters_that_the_stream_does_not_know(monkeypatch):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="ascii"))
    put("Größe")
    put_table(Table("Größe", ("a",), [("ä",)]))
    assert raw.getvalue().startswith(b"Gr??e\n")


def test_numbers():
    assert number(1.26) == "1.3"
    assert number(1.26, 3) == "1.260"
    assert number(float("nan")) == "-"


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


def test_a_recording_with_control_characters_in_its_names(tmp_path, capsys):
    (tmp_path / "recording.toml").write_text(
        'format = 1\nname = "a\\u001b[2J"\nfps = 10\ncalibration = "\\u001bc.toml"\n'
        '[[views]]\nname = "N\\u001b]0;x\\u0007"\nkind = "mo\\u202eno"\n',
        encoding="utf-8",
    )
    for arguments in (["info"], ["info", "--json"], ["cloud", "--frame=0", "-o", "c.ply"]):
        assert main([arguments[0], str(tmp_path), *arguments[1:]]) == 2
        told = "".join(capsys.readouterr())
        assert "\\u001b" in told or "\\x1b" in told  # as a text, or as Python quotes it
        assert told.replace("\n", "").isprintable()
