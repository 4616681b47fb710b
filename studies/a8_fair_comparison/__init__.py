"""Twelve laws with the same measurements, tuned alike and compared in scenarios where none was tuned."""
