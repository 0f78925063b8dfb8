"""How a time level, or the steady state, is found."""
