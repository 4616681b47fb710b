"""The wing of manipulators: from the description of an arm to M, C and G, and to its plant, laws and observers.

The joints of an arm are named here and in no room for any plant; only `cli`, the studies and the face of the package
import it. Read `mechanics` first, then `manipulator.py` and `laws`; `printed` compares the equations of a paper with
an arm.
"""
