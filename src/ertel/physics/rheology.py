"""Rheology: the flow coefficients (mobilities) of the film along X and along Y.

A law gives two mobilities at every node.  The Poiseuille flux through the face between two nodes is

    - eps_x dP/dX,    - eps_y dP/dY.

Here eps is the mean of the two nodes, and the gradient is their difference over the spacing.

The solver's automatic Jacobian makes these assumptions about a law, and no others:

* A mobility is pointwise.  At a node it depends on P and H at that node (through density, viscosity and film thickness)
  and on numbers.  Its derivatives with respect to P and H are then fields and cost two evaluations.
* Gradients of P enter only the flux at the faces, and linearly.  An oil that thins under shear has no such law: its
  flux through a face is that of `ertel.equations.thinning`.
* A mobility is differentiable where H > 0 and zero where H <= 0.  H <= 0 occurs when the surfaces overlap because the
  grid is too coarse for the film; nothing flows there.

A law is a named tuple of its parameters, so that they can change without a new compilation.  It uses the operators and
the namespace of its input arrays: NumPy or JAX, traced or not.
"""

from typing import Any, NamedTuple, Protocol

Array = Any  # a NumPy or JAX array of any shape


class Rheology(Protocol):
    """A law for the flow of the film."""

    def mobility(self, density: Array, viscosity: Array, film: Array, lambda_bar: Array | float) -> tuple[Array, Array]:
        """The dimensionless mobilities along X and along Y; the same array twice where they are equal.

        density is rho/rho0 and viscosity is eta/eta0 at the pressure of each node; film is H.  All have the same shape.
        """
        ...


class Newtonian(NamedTuple):
    """Newtonian oil: eps = rho H^3/(eta lambda_bar) in all directions, eq. (1)."""

    def mobility(self, density: Array, viscosity: Array, film: Array, lambda_bar: Array | float) -> tuple[Array, Array]:
        """The same mobility for X and Y."""
        open_film = film.__array_namespace__().maximum(film, 0.0)
        eps = density * open_film**3 / (viscosity * lambda_bar)
        return eps, eps


NEWTONIAN = Newtonian()
