"""The command line of the library: `python -m sunset_ros`, or `sunset-ros`."""

import argparse
import os
import sys
from collections.abc import Sequence

from sunset_ros.commands import add_arguments
from sunset_ros.errors import SunsetError

_EXIT_BAD_INPUT = 2
_EXIT_INTERRUPTED = 130
_SIGNALLED = 128
"""Added to the number of a signal, as shells do."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command, and return the exit code."""
    parser = argparse.ArgumentParser(prog="sunset-ros")
    add_arguments(parser)
    try:
        parsed = parser.parse_args(arguments)
        code = parsed.execute(parsed)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader of the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt as error:
        return _SIGNALLED + int(*error.args) if error.args else _EXIT_INTERRUPTED
    except SunsetError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return _EXIT_BAD_INPUT
    return code or 0


if __name__ == "__main__":
    sys.exit(main())
