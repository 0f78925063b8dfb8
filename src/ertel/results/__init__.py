"""Results of a run: variables, Dataset, provenance, summary, diagnostics, Result, fronts, waves, pictures."""
