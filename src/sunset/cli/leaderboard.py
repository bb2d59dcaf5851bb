"""`sunset leaderboard`: verify bundles, and publish their managing systems on a page."""

import argparse

import sunset
from sunset.cli.options import add_path, call
from sunset.cli.progress import stages_progress
from sunset.cli.verify import EXIT_DIFFERS, add_rerun_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Verify bundles as 'sunset verify' does, and write a folder to publish: a page with the managing systems of "
        "those that pass, a table for each group of comparable campaigns, and the bundles. A bundle that does not pass "
        "is named with the reason. Exit code 1 says that there is such a bundle, 2 that a file is missing."
    )
    add_path(parser, "bundles", "BUNDLE.zip", "what 'sunset bundle' wrote", nargs="+")
    add_path(parser, "--out", "SITE", "the new folder of the page", required=True)
    add_rerun_options(parser)
    add_path(
        parser,
        "--salt-file",
        "FILE",
        "the published salt of a sealed round: the split of each bundle is drawn again from it",
    )


def execute(arguments: argparse.Namespace) -> int:
    with stages_progress() as progress:
        board = call(sunset.leaderboard, arguments, progress=progress)
    print(board)
    return EXIT_DIFFERS if board.refused else 0
