"""Linear analysis of the loops at rest and along the first scenario."""
