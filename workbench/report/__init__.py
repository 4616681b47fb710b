"""The report of a study: a live page, a PDF, tables and figures in a folder.

`pictures` and `loop_pictures` make figures of results and of linear loops; `figures` draws them; `live` gathers what a
reader can turn on a page. The room knows documents and decides how they look; it does not know how their numbers were
made. Read `outline` first, then `html_page`.
"""
