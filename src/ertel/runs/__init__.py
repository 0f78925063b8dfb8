"""From a case to its course, one or many."""
