"""Options that several verbs share."""

import argparse

__all__ = ["add_flight_options", "at_least_one"]


def at_least_one(text: str) -> int:
    """Parse a whole number of at least 1."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got {text!r}")
    return number


def add_flight_options(parser: argparse.ArgumentParser) -> None:
    """Add what says how a mission is flown, whoever manages it."""
    parser.add_argument(
        "--model", default="lite", metavar="NAME|DIR", help="segmentation model (default: lite)"
    )
    parser.add_argument("--bag", metavar="PATH", help="a rosbag2 to fly instead of the default flight")
    parser.add_argument(
        "--middleware",
        default="sim",
        choices=["sim"],
        help="where the nodes run: sim = in this process, virtual time (default)",
    )
    parser.add_argument(
        "--no-cache", action="store_true", help="compute every inference again instead of looking it up"
    )
