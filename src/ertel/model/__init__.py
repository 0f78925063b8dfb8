"""The model: the case (`case`), the state (`state`), and the equations (`contact`, `approach`)."""
