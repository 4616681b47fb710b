"""Planning: numbers of laws that plan."""
