"""The part that dry-contact codes share with ertel: the half space's deformation under a pressure.  Prints a table.

    python benchmarks/peers/deformation.py [nodes ...]       (129 257 513 1025 unless said; one minute)

The pressure is Hertz', |X|, |Y| <= 3; all three have constant pressure on a cell, zero-padded FFT, double precision.
"Error" is the largest to Hertz' displacement 1 - r²/2 inside the contact; "difference" that to ertel.  tamaas and
ContactMechanics are taken where they are installed.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import grids, header, row, seconds

HALF_WIDTH = 3.0
CONTACT_MODULUS = np.pi / 2  # E/(1 - nu^2) in the units of eq. (3): displacement = (2/pi^2) integral of P/distance
COLUMNS = ("program", "nodes", "error", "difference", "seconds", "seconds / ertel's")


def main() -> None:
    programs = {"ertel": by_ertel, "tamaas": by_tamaas, "ContactMechanics": by_contact_mechanics}
    skipped = []
    header(COLUMNS)
    for nodes in grids((129, 257, 513, 1025)):
        x = (np.arange(nodes) - (nodes - 1) / 2) * spacing(nodes)
        square = x[:, None] ** 2 + x[None, :] ** 2
        P, inside = np.sqrt(np.maximum(1.0 - square, 0.0)), square <= 1.0
        own: tuple[Any, float] | None = None
        for name, program in programs.items():
            try:
                work = program(nodes, P)
            except ImportError:
                skipped.append(name)
                continue
            w, wall = np.array(work())[:nodes, :nodes], seconds(work)
            own = own or (w, wall)
            error = float(np.abs(w - (1.0 - square / 2))[inside].max())
            row(name, f"{nodes}²", error, float(np.abs(w - own[0]).max()), wall, wall / own[1])
    for name in dict.fromkeys(skipped):
        print(f"\n{name} skipped: it is not installed.")


def spacing(nodes: int) -> float:
    return 2 * HALF_WIDTH / (nodes - 1)


def by_ertel(nodes: int, P: Any) -> Callable[[], Any]:
    import jax
    import jax.numpy as jnp

    from ertel.numerics import halfspace
    from ertel.numerics.grid import Grid

    kernel = halfspace.kernel(Grid.square(nodes, HALF_WIDTH), 2 / np.pi**2)
    convolve = jax.jit(lambda kernel, P: kernel.displacement(P))
    on_device = jnp.asarray(P)
    return lambda: jax.block_until_ready(convolve(kernel, on_device))


def by_tamaas(nodes: int, P: Any) -> Callable[[], Any]:
    import tamaas

    model = tamaas.Model(tamaas.model_type.basic_2d, [nodes * spacing(nodes)] * 2, [nodes] * 2)
    model.E, model.nu = CONTACT_MODULUS, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "free")
    model.traction[...] = P

    def work() -> Any:
        model.operators["free"](model.traction, model.displacement)
        return model.displacement

    return work


def by_contact_mechanics(nodes: int, P: Any) -> Callable[[], Any]:
    from ContactMechanics import FreeFFTElasticHalfSpace

    half_space = FreeFFTElasticHalfSpace((nodes,) * 2, CONTACT_MODULUS, (nodes * spacing(nodes),) * 2)
    forces = -P * spacing(nodes) ** 2
    return lambda: half_space.evaluate_disp(forces)


if __name__ == "__main__":
    main()
