"""The version of ertel that is installed."""

from importlib.metadata import PackageNotFoundError, version


def installed_version() -> str:
    """As the package's metadata have it; "0+unknown" for a source tree that was not installed."""
    try:
        return version("ertel")
    except PackageNotFoundError:
        return "0+unknown"
