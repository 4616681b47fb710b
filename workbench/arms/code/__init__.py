"""The equations of an arm written out, for reading and as programs."""
