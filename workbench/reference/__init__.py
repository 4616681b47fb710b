"""One run, exactly: variable steps, every switch located, and sliding along surfaces."""

from workbench.reference.run import Reference, reference, reference_of_function

__all__ = ["Reference", "reference", "reference_of_function"]
