"""Odd arguments for every public name: what is not refused in a sentence of the workbench's own is a raw error.

examples   the calls that the examples of the docstrings make, with a user's arguments
rooms/     calls that no example shows: functions of a user's own, and names that a study uses without a docstring
ports      arguments of methods that no example calls
oddities   values that nobody should give, and plain ones that somebody might
calls      good calls with one to three arguments replaced, each from its seed and number alone
judgement  which outcomes are raw
workers    processes that make the calls, so that a crash is an outcome too
"""
