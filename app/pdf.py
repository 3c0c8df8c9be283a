"""A page of HTML as a PDF, by Qt: ``python -m PACKAGE.pdf PAGE.html FILE.pdf``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QBuffer, QIODevice, QMarginsF, QRectF, QSizeF, Qt
from PySide6.QtGui import (
    QAbstractTextDocumentLayout,
    QFont,
    QGuiApplication,
    QImage,
    QPageLayout,
    QPageSize,
    QPaintDevice,
    QPainter,
    QPalette,
    QPdfWriter,
    QTextDocument,
)

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError

_DPI = 96
_MARGIN_MM = 16.0
_FOOT = 22.0
"""Height of the line at the foot of every page, in the document's units."""


def write_pdf(html: str, path: Path, title: str = "") -> int:
    """Write a page as PDF, A4, with numbered pages; returns how many there are.

    A QGuiApplication has to be there.

    Raises
    ------
    InputError
        Where it cannot be written.
    """
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    count = _drawn(html, buffer, title or path.stem)
    write_file(path, bytes(buffer.data().data()))
    return count


def _drawn(html: str, device: QIODevice, title: str) -> int:
    writer = QPdfWriter(device)
    writer.setTitle(title)
    writer.setCreator("stereotrack")
    writer.setResolution(_DPI)
    writer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
    margins = QMarginsF(_MARGIN_MM, _MARGIN_MM, _MARGIN_MM, _MARGIN_MM)
    writer.setPageMargins(margins, QPageLayout.Unit.Millimeter)
    sheet = QRectF(0.0, 0.0, writer.width(), writer.height())
    document = _laid_out(html, writer, sheet)
    painter = QPainter(writer)
    count = document.pageCount()
    for page in range(count):
        if page:
            writer.newPage()
        _paint(painter, document, page, sheet, f"{title}   {page + 1} / {count}")
    painter.end()
    return count


def page_picture(html: str, page: int, title: str = "", scale: float = 1.0) -> QImage:
    """Picture of one page, as :func:`write_pdf` sets it; the first one is 0.

    Raises
    ------
    IndexError
        For a page that there is not.
    """
    whole = QPageSize(QPageSize.PageSizeId.A4).sizePixels(_DPI)
    margin = _MARGIN_MM / 25.4 * _DPI
    sheet = QRectF(0.0, 0.0, whole.width() - 2 * margin, whole.height() - 2 * margin)
    picture = QImage(whole * scale, QImage.Format.Format_RGB32)
    picture.setDotsPerMeterX(round(_DPI / 0.0254))
    picture.setDotsPerMeterY(round(_DPI / 0.0254))
    picture.fill(Qt.GlobalColor.white)
    document = _laid_out(html, picture, sheet)
    count = document.pageCount()
    if not 0 <= page < count:
        raise IndexError(f"page {page} of {count}")
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    painter.scale(scale, scale)
    painter.translate(margin, margin)
    _paint(painter, document, page, sheet, f"{title}   {page + 1} / {count}")
    painter.end()
    return picture


def _laid_out(html: str, device: QPaintDevice, sheet: QRectF) -> QTextDocument:
    """The page as a document whose pages leave room for a foot."""
    document = QTextDocument()
    document.documentLayout().setPaintDevice(device)
    document.setDocumentMargin(0.0)
    document.setHtml(_fitted(html, int(sheet.width())))
    document.setPageSize(QSizeF(sheet.width(), sheet.height() - _FOOT))
    return document


def _paint(painter: QPainter, document: QTextDocument, page: int, sheet: QRectF, foot: str) -> None:
    height = sheet.height() - _FOOT
    painter.save()
    painter.translate(0.0, -page * height)
    part = QRectF(0.0, page * height, sheet.width(), height)
    painter.setClipRect(part)
    # paper is white, whatever the theme of the screen
    context = QAbstractTextDocumentLayout.PaintContext()
    context.clip = part
    context.palette.setColor(QPalette.ColorRole.Text, Qt.GlobalColor.black)
    document.documentLayout().draw(painter, context)
    painter.restore()
    painter.setFont(QFont(document.defaultFont().family(), 7))
    line = QRectF(0.0, height, sheet.width(), _FOOT)
    painter.drawText(line, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignBottom, foot)


def _fitted(html: str, width: int) -> str:
    """Pictures as wide as the sheet; tables with hair lines, as Qt's own HTML wants them."""
    shown = html.replace(' width="960"', f' width="{width}"').replace(
        ' width="640"', f' width="{min(640, width)}"'
    )
    return shown.replace(
        "<table>", '<table border="0" cellspacing="0" cellpadding="0" style="border-collapse: '
        'collapse; border-style: solid; border-color: #d0d7de; border-width: 0px;">'
    )  # fmt: skip


def main(arguments: Sequence[str]) -> int:
    """Convert the page that is named."""
    if len(arguments) != 2:
        sys.stderr.write("Usage: python -m app.pdf PAGE.html FILE.pdf\n")
        return 2
    page, pdf = (Path(word) for word in arguments)
    application = QGuiApplication.instance() or QGuiApplication(["stereotrack"])
    try:
        write_pdf(page.read_text("utf-8"), pdf)
    except (InputError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    finally:
        del application
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
