"""Blocks of any loop: plants, laws, observers, references and disturbances, and the closed loop that they make.

A block is a frozen dataclass of numbers whose methods are expressions of CasADi; its ports say by name, shape and unit
what it takes and gives. The room knows no simulation and no design. Read `loop` first, then `plants` and `laws`.
"""
