"""Annotating again blindly, and how well two readings agree."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from app.features.annotate.exchange.agreement import AgreementDialog, agreement_report
from stereotrack_core.annotation.agreement import differences
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.blind_repeats import BlindRepeats
from stereotrack_core.project.clicks import blind_repeat, place_clicks
from stereotrack_core.project.project import Project

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def annotated(project, make):
    """Forty frames with clicks."""
    project.apply(place_clicks(make.clicks_at(range(40), sigma=2.0, seed=1)))
    return project


def test_what_is_under_way_survives_closing(recording, make):
    path = recording.folder.parent / "again.stereotrack"
    with Project.create(path, recording.folder) as project:
        project.apply(place_clicks(make.clicks_at([3])))
        BlindRepeats(project).begin(3)
    with Project.open(path) as project:
        assert BlindRepeats(project).active == 3


def test_the_measured_sigma_comes_from_repeats(annotated, make):
    again = make.clicks_at(range(0, 40, 2), sigma=2.0, seed=9)
    annotated.apply(blind_repeat(place_clicks(again)))
    assert len(annotated.clicks.repeat_differences()) == 20 * 36
    sigmas = annotated.click_sigmas(usual=6.0)
    assert set(sigmas) == set(NINE.names)
    np.testing.assert_allclose(list(sigmas.values()), 2.0, atol=0.6)


def report_of(project, second, make):
    return agreement_report(differences(project.clicks.all(), second), make.CAMERAS, NINE)


def test_the_report_says_words_first(annotated, make):
    report = report_of(annotated, make.clicks_at(range(10), sigma=2.0, seed=9), make)
    assert report.verdict.startswith("Good: click uncertainty ")
    assert "(360 pairs in 10 frames)" in report.verdict
    assert [row[0].text for row in report.rows][:2] == ["all landmarks", "left shoulder"]
    assert report.rows[0][1].text == "360"
    assert 1.7 < float(report.rows[0][2].text) < 2.3
    assert 3.0 < float(report.rows[1][7].text) < 20.0
    assert 0.5 < float(report.rows[1][9].text) < 6.0


def test_a_landmark_that_is_understood_differently_is_named(annotated, make):
    second = [
        replace(c, position=(c.position[0] + 15, c.position[1])) if c.landmark == "left_hip" else c
        for c in make.clicks_at(range(10), sigma=2.0, seed=9)
    ]
    report = report_of(annotated, second, make)
    assert "Agree on where the left hip is: the two positions differ by 16 px" in report.remedy


def test_the_dialog_shows_and_copies(qtbot, annotated, make, shown):
    other = []
    dialog = shown(AgreementDialog(lambda: None, lambda: other.append(1)), 940, 420)
    report = report_of(annotated, make.clicks_at(range(10), sigma=2.0, seed=9), make)
    dialog.show_report("A against B", report)
    assert dialog.table.model().rowCount() == 10
    qtbot.keyClick(dialog.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = QGuiApplication.clipboard().text().splitlines()
    assert len(lines) == 10
    assert lines[0].startswith("all landmarks\t360\t")
    qtbot.mouseClick(dialog.other_button, LEFT)
    assert other
