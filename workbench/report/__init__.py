"""A study's document on paper: a page, a PDF, tables and figures in a folder.

The room knows documents, and decides how they look; it knows nothing of how their numbers were made. Read `outline`
first, then `html_page`.
"""
