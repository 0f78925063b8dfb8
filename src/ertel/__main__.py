"""python -m ertel"""

from ertel.apps.cli import main

if __name__ == "__main__":
    main()
