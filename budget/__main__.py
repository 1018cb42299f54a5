"""`python -m budget`: the command line without its script."""

from budget.cli import main

if __name__ == "__main__":
    main()
