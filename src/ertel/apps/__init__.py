"""Programs built on ertel."""
