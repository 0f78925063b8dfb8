"""The law of Carreau and Yasuda for oils that thin under shear."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from ertel.physics.fluidity import ALMOST_ZERO, EXPONENT
from ertel.physics.registry import FLUIDITY_LAWS, arrays_of
from ertel.physics.units import ABOVE_ZERO, STRESS, Meaning


@FLUIDITY_LAWS.register("carreau-yasuda")
@dataclass(frozen=True)
class CarreauYasuda:
    """phi = (1 + x^a)^{(1/n - 1)/a} with x = |tau|/G; a = 2 is Carreau's law.  A larger a bends more sharply at G."""

    G: Annotated[float, STRESS, Meaning("stress at which the oil begins to thin", "5 MPa")]
    n: Annotated[float, EXPONENT, Meaning("exponent; 1: Newtonian", 0.5)]
    a: Annotated[float, ABOVE_ZERO, Meaning("how sharply the law bends; 2: Carreau's", 2)]
    reference: ClassVar[str] = (
        "Yasuda K, Armstrong RC, Cohen RE. Shear flow properties of concentrated solutions of linear and star branched "
        "polystyrenes. Rheol Acta 1981;20:163-178; here in the stress"
    )

    def fluidity(self, stress: Any, pressure: Any) -> Any:
        xp = arrays_of(stress)
        power = xp.exp(self.a * xp.log(xp.maximum(stress / self.G, ALMOST_ZERO)))
        return xp.exp((1.0 / self.n - 1.0) / self.a * xp.log(1.0 + power))

    def stress(self, rate: Any, pressure: Any) -> Any:
        """The form in the shear rate."""
        x = arrays_of(rate).maximum(rate / self.G, ALMOST_ZERO)
        return rate * (1.0 + x**self.a) ** ((self.n - 1.0) / self.a)
