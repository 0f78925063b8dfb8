"""The figures of the paper, simulated, and beyond."""
