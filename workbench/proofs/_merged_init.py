"""Claims about closed loops: each with its hypotheses, its verdict, and the run that breaks it where one was found.

The room knows equations and metrics, and searches them within stated bounds. Read `verdicts` first, then `falsify`.
"""
