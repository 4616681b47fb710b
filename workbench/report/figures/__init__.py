"""Figures in one style, readable in black and white, and the only door to matplotlib.

`sheet.draw` makes the figures of a report; `axes.plot` draws them on matplotlib's own axes, for a notebook.
"""
