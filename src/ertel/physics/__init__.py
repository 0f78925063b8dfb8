"""Pointwise laws and closed forms, without a grid: scales, Hertz, the oil, the motion, surfaces, film formulas."""
