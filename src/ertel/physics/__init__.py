"""Pointwise laws and closed-form solutions without a grid: scales, Hertz, oil, motion, surfaces, film formulas."""
