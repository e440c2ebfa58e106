"""``python -m superegg`` is the program."""

from superegg._program import main

if __name__ == "__main__":
    main()
