"""Runs of one case or of many."""
