"""The paper's arm with friction, identified from logs of its own, and the cost of not having known it."""
