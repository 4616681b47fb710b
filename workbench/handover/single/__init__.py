"""A sampled law in single precision: its numbers as C has them, and a proved bound of what they lose."""
