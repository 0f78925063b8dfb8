"""python -m ertel"""

from ertel.cli import main

if __name__ == "__main__":
    main()
