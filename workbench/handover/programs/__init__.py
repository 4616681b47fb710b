"""A sampled law as a program for Python, CasADi, python-control or MATLAB."""
