"""Results of a run: variables, Dataset, provenance, summary, diagnostics, measurements and fronts."""
