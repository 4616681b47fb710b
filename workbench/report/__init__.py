"""The report of a study: a live page, a PDF, tables and figures in a folder.

`pictures` and `loop_pictures` choose the curves of a figure; `figures` draws a figure as SVG; `live` gathers the
loops that a reader can turn on a page. This package knows documents and decides how they look; it does not know how
their numbers were made. Read `outline` first, then `html_page`.
"""
