"""One file a room: `MODULES` whose public names it holds, a valid call of each, and arguments for methods by name.

A call is a `functools.partial`; of what is no call, the thing itself. `arguments()` maps "name" or "Class.method.name"
to a function from the object whose method is called to a valid argument.
"""
