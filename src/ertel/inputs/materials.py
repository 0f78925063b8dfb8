"""Materials of the two bodies by name: `ertel.materials`.

>>> from ertel import materials
>>> steel, glass = materials.get("steel"), materials.get("glass")
>>> round(steel.reduced_modulus(glass) / 1e9, 1)
124.9
>>> materials.names()
('glass', 'sapphire', 'silicon-nitride', 'steel', 'tungsten-carbide')
"""

from ertel.inputs.oils import material as get
from ertel.inputs.oils import material_names as names

__all__ = ["get", "names"]
