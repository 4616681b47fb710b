"""The choices that the paper does not state, drawn and fitted, and the rankings that follow."""
