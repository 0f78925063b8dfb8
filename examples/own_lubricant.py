"""An impact with a viscosity law of one's own: eta/eta0 = (1 + p/p1)^n, without a derivative.

python examples/own_lubricant.py
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from jax.tree_util import register_dataclass

import ertel
from ertel.physics.lubricant import Lubricant


@register_dataclass
@dataclass(frozen=True)
class Power:
    """eta/eta0 = (1 + p_h P/p1)^n: a law that grows more slowly than Barus'; p_ratio = p_h/p1."""

    p_ratio: float
    n: float
    reference: ClassVar[str] = "an example"

    def viscosity(self, P: Any) -> Any:
        """eta/eta0 at P = p/p_h, of P's shape."""
        return (1.0 + self.p_ratio * P) ** self.n


def central_films(nodes: int = 129) -> tuple[float, float]:
    """H_c at maximum approach with Roelands' law and with the power law of the same alpha."""
    case = ertel.parse_case({"contact": {"kind": "impact", "M": 200, "L": 10}, "solver": {"nodes": nodes}})
    power = Power(p_ratio=2.0, n=case.parameters.alpha_bar / 2.0)  # n p_h/p1 = alpha_bar
    own = replace(case, lubricant=Lubricant(power, case.lubricant.density_law))
    first, second = (ertel.simulate(c).summary["max_approach"]["H_c"] for c in (case, own))
    return first, second


if __name__ == "__main__":
    roelands, power = central_films()
    print(f"central film at maximum approach: Roelands {roelands:.4f}, power law {power:.4f} a*^2/R")
