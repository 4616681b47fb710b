"""Sensitivity of each law to the numbers of the arm, the disturbance and its own gains."""
