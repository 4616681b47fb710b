"""Calls that no example shows, one file a room: `calls()`, and `arguments()` for the methods of what they make.

A call is a `functools.partial`. `arguments()` maps "name" or "Class.method.name" to a function from the object whose
method is called to a good argument. A public name belongs into an example of its docstring instead.
"""
