"""What a run says: variables, Dataset, provenance, summary, diagnostics, Result, fronts, waves, pictures."""
