"""A document as data: words, tables, figures and verdicts.

The room knows numbers with their errors and says what stands where; it knows nothing of looks, which are `report`'s.
Read `document` first.
"""
