"""The kernel: from a `StepMap` to the function that marches it over many runs, in machine code or in NumPy.

It knows the operations of CasADi, IEEE 754 and LLVM, but no equation, no metric and no study.
Read `graph.py` and `plan.py` first, then `lowering.py` and `native.py`. Operations and their spellings are `machines`'.
"""
