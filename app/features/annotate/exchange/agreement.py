"""How well two readings agree, in words and numbers: the same person again, or another project."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from PySide6.QtWidgets import QDialog, QWidget

from stereotrack_core.annotation.agreement import (
    Agreement,
    AgreementInSpace,
    Difference,
    agreement,
    agreement_by_landmark,
    agreement_in_space,
    common_frames,
)
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.counting import counted
from stereotrack_core.geometry.camera import Camera

from ....widgets.forms.form_dialog import push_button
from ....widgets.style.building import hbox, label, vbox
from ....widgets.tables.table import RIGHT, Cell, CellRow, CellTable, Column

GOOD_PX, FAIR_PX = 3.0, 8.0
"""Up to these standard deviations of a click two readings agree well, or well enough."""

FEW = 20  # fewer pairs than this say little
_BIASED = 0.7
"""Share of the median distance that the mean difference has where both mean another place."""


COLUMNS = (
    Column("Landmark"),
    Column("Pairs", "Images in which both annotations have a position", RIGHT),
    Column("σ [px]", "Standard deviation of one click per axis, from the median distance", RIGHT),
    Column("Median [px]", "Median distance, pixels", RIGHT),
    Column("95 %", "95th percentile of the distances, pixels", RIGHT),
    Column("Largest", "Largest distance, pixels", RIGHT),
    Column("Bias", "Mean of second minus first: pixels to the right, and down", RIGHT),
    Column("Median [mm]", "Median distance in 3-D, where both have it in two cameras", RIGHT),
    Column("95 %", "95th percentile of the distances in 3-D, millimetres", RIGHT),
    Column("Limb [°]", "Median angle between the limb directions of both annotations", RIGHT),
    Column("95 %", "95th percentile of the angles, degrees", RIGHT),
    Column("Only one", "Images in which only one of the two sees the landmark", RIGHT),
)
"""Of the table: a row for all landmarks together, then for each of them."""


@dataclass(frozen=True)
class AgreementReport:
    """What is said about two readings."""

    verdict: str
    remedy: str
    rows: tuple[CellRow, ...]


def agreement_report(
    found: Iterable[Difference],
    cameras: Mapping[str, Camera],
    landmarks: LandmarkSet,
    sigmas: Mapping[str, float] | None = None,
) -> AgreementReport:
    """Compare two readings over the frames that both have annotated.

    `sigmas`: standard deviation of a click by landmark, pixels, that the fit takes from them.
    """
    common = common_frames(found)
    together = agreement(common)
    each = agreement_by_landmark(common)
    space = agreement_in_space(common, cameras, landmarks)
    rows = [_cells("all landmarks", "", together)]
    for landmark in landmarks.landmarks:
        if landmark.name in each:
            own, far = each[landmark.name], space[landmark.name]
            rows.append(_cells(landmark.label, landmark.colour, own, far))
    frames = len({one.key.frame for one in common})
    remedy = _remedy(each, together, landmarks)
    if sigmas and together.count:
        low, high = min(sigmas.values()), max(sigmas.values())
        taken = f"The fit therefore uses click uncertainties of {low:.1f} to {high:.1f} px."
        remedy = f"{remedy} {taken}".strip()
    return AgreementReport(_verdict(together, frames), remedy, tuple(rows))


def _verdict(together: Agreement, frames: int) -> str:
    if not together.count:
        return "Nothing to compare: no image has the same landmark placed in both."
    sigma = together.robust_sigma
    word = "Good" if sigma <= GOOD_PX else "Fair" if sigma <= FAIR_PX else "Poor"
    pairs = f"{counted(together.count, 'pair')} in {counted(frames, 'frame')}"
    few = " Few pairs; the result may change with more." if together.count < FEW else ""
    return f"{word}: click uncertainty {sigma:.1f} px per axis ({pairs}).{few}"


def _remedy(each: Mapping[str, Agreement], together: Agreement, landmarks: LandmarkSet) -> str:
    known = {name: one for name, one in each.items() if one.count and name in landmarks.names}
    if not known:
        return "Annotate some frames twice, or choose a project of the same recording."
    biased = [name for name, one in known.items() if _is_biased(one)]
    said = [
        f"Agree on where the {landmarks[name].label} is: the two positions differ by "
        f"{math.hypot(*known.pop(name).bias):.0f} px on average."
        for name in biased
    ]
    worst = max(known, key=lambda name: known[name].robust_sigma, default="")
    if worst and known[worst].robust_sigma > max(1.5 * together.robust_sigma, GOOD_PX):
        said.append(
            f"Check the {landmarks[worst].label}: its click uncertainty is "
            f"{known[worst].robust_sigma:.1f} px."
        )
    if together.disputed:
        images = counted(together.disputed, "image")
        said.append(f"{images} in which only one of the two sees a landmark.")
    return " ".join(said)


def _is_biased(one: Agreement) -> bool:
    bias = math.hypot(*one.bias)
    return one.count >= FEW and bias > max(_BIASED * one.median, 1.0)


def _cells(
    name: str, colour: str, own: Agreement, space: AgreementInSpace | None = None
) -> CellRow:
    """Row of one landmark, or of all together if `colour` is empty."""
    bias = "–" if math.isnan(own.bias[0]) else "{:+z.1f}, {:+z.1f}".format(*own.bias)
    pixels = (own.robust_sigma, own.median, own.p95, own.largest)
    known = (space.median_mm, space.p95_mm, space.median_deg, space.p95_deg) if space else ()
    solid = (*map(_number, known),) or ("–",) * 4
    texts = (str(own.count), *map(_number, pixels), bias, *solid, str(own.disputed))
    bold = not colour
    return (Cell(name, swatch=colour, bold=bold), *(Cell(text, bold=bold) for text in texts))


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.1f}"


class AgreementDialog(QDialog):
    """A verdict, what to do about it, and the numbers of each landmark.

    `again` compares the passes of the blind repeats, `other` asks for another project.
    """

    def __init__(
        self,
        again: Callable[[], object],
        other: Callable[[], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Annotator agreement")
        self._words, self.verdict, self.remedy = label("", "muted"), label("", "heading"), label()
        tip = "Compare the first and second passes of the blind repeats"
        again_button = push_button("&Blind repeats", again, tip)
        tip = "Compare with another annotator's project of this recording"
        self.other_button = push_button("&Other project …", other, tip)
        self.table = CellTable("Agreement by landmark", COLUMNS)
        below = hbox(None, push_button("Close", self.reject))
        top = hbox((self._words, 1), again_button, self.other_button)
        parts = (top, self.verdict, self.remedy, (self.table, 1), below)
        self.setLayout(vbox(*parts, margins=(9, 9, 9, 9)))
        self.resize(1020, 430)

    def show_report(self, compared: str, report: AgreementReport) -> None:
        self._words.setText(compared)
        self.verdict.setText(report.verdict)
        self.remedy.setText(report.remedy)
        self.remedy.setVisible(bool(report.remedy))
        self.table.show_rows(report.rows)
