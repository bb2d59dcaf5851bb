"""`sunset scenarios`: list, show, generate and check."""

import argparse
import json
import sys

import sunset
from sunset.cli.options import add_count_option, add_json_option, add_path, call
from sunset.cli.parser import Parser
from sunset.errors import InvalidInputError, OutputError
from sunset.files.outputs import write_text
from sunset.texts.sentences import counted


def add_arguments(parser: Parser) -> None:
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser("list", help="list the scenarios of the suites")
    listing.add_argument("--suite", metavar="NAME|DIR", help="of one suite, or of a folder of scenario files")
    add_json_option(listing)
    listing.set_defaults(execute=list_scenarios)
    showing = actions.add_parser("show", help="print a scenario as YAML")
    showing.add_argument("scenario", help="a scenario's name, a YAML file, or faults joined by +")
    showing.set_defaults(execute=show)
    actions.add_parser(
        "generate",
        help="write a scenario file of given faults, or a split",
        description="Write a scenario file of given faults; or, with --split, a folder of scenarios drawn at random. "
        "The splits never share a scenario, and test has what train never has.",
        add=_add_generate,
    )
    checking = actions.add_parser("check", help="generate a split anew, and compare its scenarios")
    add_path(checking, "folder", "DIR", "that 'generate --split' has written")
    add_path(checking, "--salt-file", "FILE", "the secret that it was made with")
    checking.set_defaults(execute=check)


def _add_generate(parser: Parser) -> None:
    from sunset.api.catalogue import SPLITS  # noqa: PLC0415  not needed for the other actions

    parser.add_argument("faults", nargs="*", metavar="FAULT[=VALUE]", help="fault, with a strength if wanted")
    parser.add_argument("--name", default="", help="the scenario's name (default: the faults joined by +)")
    add_path(parser, "--out", "PATH", "file to write (default: stdout); folder of a split")
    parser.add_argument("--split", metavar="NAME", help=f"draw scenarios: {', '.join(SPLITS)}")
    add_count_option(parser, "--count", "split: how many scenarios")
    parser.add_argument("--seed", type=int, metavar="N", help="split: of the draws (default: 0)")
    flights = "split: a flight for each scenario, in place of the default one"
    parser.add_argument("--flights", action="store_const", const=True, help=flights)
    add_path(parser, "--salt-file", "FILE", "split: a secret that the draws depend on")
    parser.set_defaults(execute=generate_scenario)


def list_scenarios(arguments: argparse.Namespace) -> None:
    suites = sunset.list_suites() if arguments.suite is None else [arguments.suite]
    names = {suite: sunset.list_scenarios(suite) for suite in suites}
    if arguments.json:
        print(json.dumps(names, sort_keys=True))
    else:
        print("\n".join(name for suite in names.values() for name in suite))


def show(arguments: argparse.Namespace) -> None:
    sys.stdout.write(sunset.load_scenario(arguments.scenario).to_yaml())


def generate_scenario(arguments: argparse.Namespace) -> None:
    of_split = ("split", "count", "seed", "flights", "salt_file")
    if given := [name for name in of_split if getattr(arguments, name) is not None]:
        if arguments.faults or arguments.name:
            option = f"--{given[0].replace('_', '-')}"
            raise InvalidInputError(
                f"A split is drawn, not made of given faults: leave out the faults and --name, or {option}."
            )
        _generate_split(arguments)
        return
    if not arguments.faults:
        raise InvalidInputError("A scenario is made of faults: name some, or draw scenarios with --split.")
    text = sunset.make_scenario(*arguments.faults, name=arguments.name).to_yaml()
    if arguments.out is None:
        sys.stdout.write(text)
        return
    if arguments.out.exists():
        raise OutputError(f"The file {arguments.out} exists: name a new one with --out.")
    write_text(arguments.out, text)
    print(f"The scenario is in {arguments.out}.", file=sys.stderr)


def _generate_split(arguments: argparse.Namespace) -> None:
    for name in ("split", "count", "out"):
        if getattr(arguments, name) is None:
            raise InvalidInputError(f"A split needs --split, --count and --out: add --{name}.")
    split = call(sunset.generate_split, arguments, seed=arguments.seed or 0, flights=bool(arguments.flights))
    print(f"{counted(split.count, 'scenario')} of {split.split} are in {arguments.out}.", file=sys.stderr)
    _print_hashes(split.sha256, split.salt_sha256)


def check(arguments: argparse.Namespace) -> None:
    split = call(sunset.check_split, arguments)
    print(f"The scenarios in {arguments.folder} are those that its description makes.", file=sys.stderr)
    _print_hashes(split.sha256, split.salt_sha256)


def _print_hashes(scenarios: str, salt: str | None) -> None:
    print(f"scenarios  SHA-256 {scenarios}")
    if salt is not None:
        print(f"salt       SHA-256 {salt}")
