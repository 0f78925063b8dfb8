"""python -m ertel, and the command ertel."""

import sys


def main() -> None:
    """The command line; Ctrl-C while it is imported ends it without a traceback."""
    try:
        from ertel.apps import cli
    except KeyboardInterrupt:
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
