"""Mathematics without a word of lubrication: grids, Fourier sums, multigrid, Newton, Krylov, time differences."""
