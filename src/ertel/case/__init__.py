"""The case, its sections and records, and the rules that they follow.  No JAX, no equation."""
