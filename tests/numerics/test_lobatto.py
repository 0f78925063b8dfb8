"""Points across a film: what they integrate exactly."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose

from ertel.numerics.lobatto import Lobatto


@pytest.mark.parametrize("points", [3, 5, 7, 10])
def test_integrals_slopes_and_partial_integrals_of_polynomials(points: int) -> None:
    across = Lobatto.of(points)
    z = np.asarray(across.z)
    assert np.array_equal(z, -z[::-1])  # a temperature in the middle of the film is at 0, not at 1e-17
    f = Polynomial(np.random.default_rng(points).normal(size=points))  # of degree n - 1
    g = Polynomial(np.random.default_rng(1).normal(size=points))
    long = Polynomial(np.random.default_rng(2).normal(size=2 * points - 2))  # of degree 2 n - 3
    exact = [np.diff(each.integ()([-0.5, 0.5]))[0] for each in (long, f.deriv() * g.deriv())]
    assert_allclose(across.integral(long(z)), exact[0], rtol=1e-12)
    assert_allclose(np.sum(g(z) * across.stiff(f(z))), exact[1], rtol=1e-11)
    assert_allclose(across.from_below(f(z)), f.integ(lbnd=-0.5)(z), atol=1e-13)
    assert_allclose(across.stiff(np.ones_like(z)), 0.0, atol=1e-11)  # a column of one temperature conducts nothing
