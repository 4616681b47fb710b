"""A study's document on paper: a page, a PDF, tables and figures in a folder."""
