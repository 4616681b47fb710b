"""From a `Step` to the function that marches it: read, rewritten, planned, lowered, compiled."""
