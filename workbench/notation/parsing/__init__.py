"""Formulas read from text and LaTeX: a grammar of their own, in which nothing is ever run as code."""
