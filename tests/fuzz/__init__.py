"""Odd arguments for every public name: what is not refused in a sentence of the workbench's own is a raw error.

rooms/     one file a room: a valid call of each of its public names
oddities   values that nobody should give, and plain ones that somebody might
calls      valid calls with one to three arguments replaced, each from its seed and number alone
judgement  which outcomes are raw
workers    processes that make the calls, so that a crash is an outcome too
"""
