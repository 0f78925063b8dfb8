"""Numerical methods that know nothing of lubrication: grids, FFT, multigrid, Newton, Krylov, backward differences."""
