"""What people read keeps to the field's words."""

import re
import runpy
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

GIVEN_UP = (
    *("episodes?", "attempts?", "peers", "contestants?", "look inside", "inside the frame"),
    *("blindly", "weave", "once more", "anew", "take in", "taken in", "take over", "taken back"),
    *("good to", "mistakes?", "somebody", "nobody", "shall", "by itself", "of its own"),
    *("first pose", "without truth", "signed with", "hurry", "robust (?:wide|narrow)"),
    *("who annotates", "not now", "worked out", "likely lost", "probably lost"),
)
"""Words that stood for a term of the field before, or are riddles."""


def texts():
    """Place and text of all that people may read, without what is put into it."""
    texts_of = runpy.run_path(str(ROOT / "tools" / "texts.py"))["texts"]
    for folder in ("app", "stereotrack_core"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            for line, text in texts_of(path.read_text(encoding="utf-8")):
                yield f"{path.relative_to(ROOT)}:{line}", re.sub(r"\{[^{}]*\}", "", text)


def test_no_word_comes_back_that_was_given_up():
    given_up = re.compile(rf"\b(?:{'|'.join(GIVEN_UP)})\b(?!_)", re.IGNORECASE)
    found = list(texts())
    assert len(found) > 3000
    assert [(place, text) for place, text in found if given_up.search(text)] == []
