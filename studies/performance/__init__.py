"""The speed of the engine beside its peers, and its limits on this machine."""
