"""What a verb suggests to do next."""

import sys
from collections.abc import Sequence


def print_next_steps(steps: Sequence[tuple[str, str]]) -> None:
    """Print command lines, each with what it does, on stderr."""
    width = max(len(command) for command, _ in steps)
    print("Next:", *(f"  {command:{width}}  {text}" for command, text in steps), sep="\n", file=sys.stderr)
