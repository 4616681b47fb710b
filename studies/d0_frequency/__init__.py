"""The linear answers of the paper's loops over frequency, beside nonlinear runs of the same loops."""
