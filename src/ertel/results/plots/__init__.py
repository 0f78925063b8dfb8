"""Pictures of a run: Dataset to matplotlib Figure.  Nothing is shown, nothing is saved."""
