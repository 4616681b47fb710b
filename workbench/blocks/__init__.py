"""Blocks of any loop: plants, laws, observers, references and disturbances, and the closed loop that they make.

A block is a frozen dataclass of numbers whose methods are expressions of CasADi. Its ports name the signals that it
takes and gives, each with a shape and a unit. This package simulates nothing and designs nothing. Read `loop` first,
then `plants` and `laws`.
"""
