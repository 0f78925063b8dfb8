"""An impact with a viscosity law of one's own: eta/eta0 = (1 + p/p1)^n, without a derivative.

python examples/own_lubricant.py
"""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import ertel


@ertel.viscosity_laws.register("power-law")
@dataclass(frozen=True)
class Power:
    """eta/eta0 = (1 + p/p1)^n: a law that grows more slowly than Barus'; p1 in Pa."""

    p1: Annotated[float, ertel.units.STRESS]  # so that a case file may say "0.3 GPa"
    n: float

    def viscosity(self, p: Any) -> Any:
        """eta/eta0 at the pressure p (Pa), of p's shape."""
        return (1.0 + p / self.p1) ** self.n


def central_films(nodes: int = 129) -> tuple[float, float]:
    """H_c at maximum approach with Roelands' law and with the power law of the same alpha."""
    alpha = 2.2e-8  # 1/Pa
    case = ertel.impact(M=200, L=10, nodes=nodes, oil=ertel.Oil(alpha=alpha))
    p1 = case.parameters.alpha_bar / alpha / 2  # Pa: half of Hertz' maximum pressure p_h* = alpha_bar/alpha
    own = replace(case, oil=ertel.Oil(alpha=alpha, viscosity=Power(p1, n=alpha * p1)))
    first, second = (ertel.simulate(c).summary["H_c"] for c in (case, own))
    return first, second


if __name__ == "__main__":
    roelands, power = central_films()
    print(f"central film at maximum approach: Roelands {roelands:.4f}, power law {power:.4f} a*^2/R")
