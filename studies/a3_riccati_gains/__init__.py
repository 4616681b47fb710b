"""Riccati gains along the path of the arm, and the loops that hold them."""
