"""The figures of "Boundary layers", by the public API of ertel alone; see `figures`."""
