"""`sunset faults`: the catalogue, and pictures of faults."""

import argparse
import json
import sys

import sunset
from sunset.api.catalogue import Fault, failure_text, get_fault, severities
from sunset.cli.options import FLIGHT, MODEL, add_json_option, add_path, add_settings, call
from sunset.cli.parser import Parser
from sunset.cli.progress import run_progress
from sunset.errors import InvalidInputError
from sunset.texts.tables import aligned


def add_arguments(parser: Parser) -> None:
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser(
        "list",
        help="list the catalogue",
        description="List the faults: where each happens, its strength in the suites and the greatest, the failure "
        "that it shows as, and what cures it, cheapest first.",
    )
    add_json_option(listing)
    listing.set_defaults(execute=list_faults)
    actions.add_parser("show", help="show one fault and what cures it", add=_add_show)
    actions.add_parser(
        "figure",
        help="draw the segmentation's entropy over time, with and without each fault that shows in it",
        description="Run once without a fault and once with each fault that shows in the entropy, as those of F4 do, "
        "and draw the paper's figure. These are five runs of 20 s of flight: it takes a minute or so.",
        add=_add_figure,
    )


def _add_show(parser: Parser) -> None:
    parser.add_argument("fault", help="its name")
    add_json_option(parser)
    add_path(
        parser,
        "--figure",
        "FILE",
        "draw what it does and what its cure does into a .png, .pdf or .svg: on a frame, or an outage over time",
    )
    parser.add_argument(
        "--frame",
        type=int,
        metavar="N",
        help="of the figure: which frame of the flight, from 0 on (default: the one in its middle)",
    )
    add_settings(parser, *MODEL)
    parser.set_defaults(execute=show)


def _add_figure(parser: Parser) -> None:
    add_path(parser, "--out", "FILE", "a .png, .pdf or .svg", required=True)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the runs")
    add_settings(parser, *FLIGHT)
    parser.set_defaults(execute=draw)


def list_faults(arguments: argparse.Namespace) -> None:
    faults = sunset.list_faults()
    if arguments.json:
        print(json.dumps({"faults": list(map(_described, faults))}, sort_keys=True))
        return
    header = ("FAULT", "NODE", "KIND", "STRENGTH", "FAILURE", "CURED BY")
    rows = (
        (
            fault.name,
            fault.node,
            fault.kind,
            "-" if fault.limits is None else f"{fault.value}, at most {fault.limits[1]:g}",
            failure_text(fault),
            fault.cured_by,
        )
        for fault in faults
    )
    print("\n".join(aligned([header, *rows], left=range(len(header)))))


def show(arguments: argparse.Namespace) -> None:
    fault = get_fault(arguments.fault)
    if arguments.figure is not None:
        with run_progress("Drawing") as (preparing, _):
            call(sunset.fault_picture, arguments, out=arguments.figure, preparing=preparing)
        print(f"The figure is in {arguments.figure}.", file=sys.stderr)
    elif arguments.frame is not None or arguments.bag is not None or arguments.device != "cpu":
        raise InvalidInputError(
            "--frame, --bag and --device are of a figure: add --figure FILE, or leave them out."
        )
    if arguments.json:
        print(json.dumps(_described(fault), sort_keys=True))
        return
    print(f"{fault.name}: {fault.description}")
    print(f"  failure    {failure_text(fault)}")
    print(f"  kind       {fault.kind}, in {fault.node}")
    print(f"  injection  {', then '.join(str(step) for step in fault.injection)}")
    if fault.limits is not None:
        print(
            f"  strength   {fault.value} in the suites; above {fault.limits[0]:g} and at most {fault.limits[1]:g}"
        )
        print(f"  severity   {severities(fault, arguments.model)}")
    print(f"  cured by   {fault.cured_by}{'; by nothing else' if fault.cures else ''}")


def draw(arguments: argparse.Namespace) -> None:
    with run_progress("Running") as (preparing, progress):
        call(sunset.fault_figure, arguments, progress=progress, preparing=preparing)
    print(f"The figure is in {arguments.out}.", file=sys.stderr)


def _described(fault: Fault) -> dict[str, object]:
    names = ("name", "failure", "node", "parameter", "value", "description")
    return {
        **{name: getattr(fault, name) for name in names},
        "kind": str(fault.kind),
        "cures": fault.cure_texts,
    }
