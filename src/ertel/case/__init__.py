"""The case, its sections and records, and the rules that they follow.  No JAX, no equation."""

import ertel.case.completion  # noqa: F401  # the constructor of a case needs it
