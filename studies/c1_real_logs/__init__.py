"""Measured logs of real machines: ours beside the published models, on data that the fits did not see."""
