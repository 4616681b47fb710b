"""The ground floor: checks of arguments for all rooms, each refusal one sentence in one vocabulary.

It knows type hints, numbers, names and shapes, and no room. Read `refusals` first; `signatures` holds the decorator
`@check_arguments`, `type_hints` what a hint takes, `notebook_display` the line and the table by which any object shows
itself.
"""
