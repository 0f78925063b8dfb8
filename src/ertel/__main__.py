"""python -m ertel, and the command ertel."""

import sys


def main() -> None:
    """The command line; Ctrl-C before it listens to signals ends it without a traceback."""
    try:
        from ertel.apps import cli

        cli.main()
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
