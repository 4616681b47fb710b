"""control-workbench: equations in, verdicts and numbers out.

A control engineer writes a robot, a law and a question; the workbench derives the model, checks the
claims, simulates the closed loops, compares the laws and writes a report that a reviewer can trust.
"""

__version__ = "0.1.0"
