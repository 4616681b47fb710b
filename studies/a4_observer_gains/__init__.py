"""Observer gains: the printed ones, those that LMIs give, and what each costs."""
