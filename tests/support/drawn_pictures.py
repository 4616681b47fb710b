"""The words of a drawn picture."""

from workbench.report.figures.figure_sheet import draw
from workbench.report.figures.pen import Pen, extent


def told(figure, monkeypatch):
    """The box (left, bottom, right, top) of each piece of text, as the pen is told to write it."""
    found = []

    def words(pen, label, x, y, size, upwards=False, color=""):
        for said, width in [(label, extent(label, size).width)] if label else []:
            high, low = 0.5 * size, 0.1 * size  # letters as low as x: lines may stand as close as a book's
            found.append((said, (x - high, y, x + low, y + width) if upwards else (x, y - low, x + width, y + high)))

    monkeypatch.setattr(Pen, "words", words)
    draw(figure)
    return found
