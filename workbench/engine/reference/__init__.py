"""One run of an equation by variable steps with every switch located, against which the simulator is tested.

The room knows one `Ode` or one function and its surfaces, follows sliding motion along them, and gives each number with
its error; it knows no batch and no step. Read `solution.py` first, then `switched_run.py` and `smooth_pieces.py`.
"""

from workbench.engine.reference.solution import ReferenceSolution, reference_of_function, reference_run

__all__ = ["ReferenceSolution", "reference_run", "reference_of_function"]
