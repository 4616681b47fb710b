"""Twelve laws given the same, tuned alike and compared in scenarios where none was tuned."""
