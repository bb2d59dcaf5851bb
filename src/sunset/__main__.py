"""`python -m sunset`."""

import sys

from sunset.cli import main

if __name__ == "__main__":
    sys.exit(main())
