"""The command line: one file a verb, one screen of output a verb.

The room knows all others and imports them inside the verbs, so that help comes at once.
Read `command` first, then `run`.
"""
