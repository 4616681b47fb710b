"""The command line: each verb has one file, and prints at most one screen.

The room knows all others and imports them inside the verbs, so that help comes at once.
Read `command` first, then `run`.
"""
