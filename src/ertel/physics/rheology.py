"""The flow of the film: how readily the oil flows under a pressure gradient, along X and along Y.

A law gives two mobilities at every node, and the flux through the face between two nodes is

    - eps_x dP/dX,    - eps_y dP/dY,    eps the mean of the two nodes, the gradient their difference over the spacing.

What a solver's automatic Jacobian may assume of a law, and all it may assume:

* A mobility is pointwise: at a node it depends on P and H at that node (through density, viscosity and film), and on
  numbers.  Its derivatives with respect to P and H are then fields, and cost two evaluations.
* Gradients of P enter the flux at faces, linearly, and nowhere else.  A law whose mobility depends on the gradient
  (Eyring's with a strong Poiseuille flow) takes it from the level before or from the last Newton iteration.
* It is differentiable wherever H > 0, and zero where H <= 0: where a grid too coarse for the film lets the surfaces
  overlap, nothing flows.

A law is a named tuple of its parameters, so that they can change without a new compilation, and uses the operators and
the namespace of the arrays that it is given: NumPy's or those of JAX, traced or not.
"""

from typing import Any, NamedTuple, Protocol

Array = Any  # a NumPy or JAX array of any shape


class Rheology(Protocol):
    """A law for the flow of the film."""

    def mobility(self, density: Array, viscosity: Array, film: Array, lambda_bar: Array | float) -> tuple[Array, Array]:
        """The dimensionless mobilities along X and along Y; the same array twice where they are equal.

        density rho/rho0, viscosity eta/eta0 at the pressure of each node, film H, all of one shape.
        """
        ...


class Newtonian(NamedTuple):
    """eps = rho H^3/(eta lambda_bar) in all directions, eq. (1)."""

    def mobility(self, density: Array, viscosity: Array, film: Array, lambda_bar: Array | float) -> tuple[Array, Array]:
        """The mobility, twice."""
        open_film = film.__array_namespace__().maximum(film, 0.0)
        eps = density * open_film**3 / (viscosity * lambda_bar)
        return eps, eps


NEWTONIAN = Newtonian()
