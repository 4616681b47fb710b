"""Figures of linear systems: sampled loops, discretisation, and frequency answers of many systems at once.

The room knows arrays and systems of python-control, and no robot, law or loop by name. Read `hold_loop.py` first for a
loop in a computer, `multirate.py` for one with several periods, and `discretization.py` for `c2d`.
"""
