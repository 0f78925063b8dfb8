"""The equations: the residual, the fluxes, the law for the approach, and the accounts of mass and energy."""
