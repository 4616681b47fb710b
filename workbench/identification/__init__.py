"""Identification: from measured signals to models with their uncertainty."""
