"""What a run says: variables, Dataset, summary, diagnostics, fronts, waves, pictures."""
