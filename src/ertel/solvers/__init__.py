"""Solvers for a time step and for the steady state."""
