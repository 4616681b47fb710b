"""A document as data: words, tables, figures and verdicts, and nothing about their looks.

The room knows numbers with their errors and says what stands where; `report` decides how it looks. Read
`document` first.
"""
