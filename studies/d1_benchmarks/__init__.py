"""Designs from specifications beside published ones: a batch of processes, robust benchmarks, and the paper's arm."""
