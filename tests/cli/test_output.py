"""Results on standard output."""

import io
import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.cli.output import Table, number, plain, put, put_json, put_table


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
