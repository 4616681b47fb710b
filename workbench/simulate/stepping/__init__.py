"""How long a step may be, and which method and step serve a whole batch at a wanted accuracy."""
