"""Chattering of the paper's arm under SMC, predicted and simulated."""
