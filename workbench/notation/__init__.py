"""Equations on paper: CasADi expressions read, proved equal, and written in five markups.

What a report prints comes from the very expressions that are simulated, so that it cannot disagree with
them; what two expressions claim to share is decided by exact rational arithmetic.
"""
