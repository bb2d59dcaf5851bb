"""`sunset faults`: the catalogue, and the figure of what faults do to the entropy."""

import argparse
import json
import sys
from pathlib import Path

from sunset.api.catalogue import draw_fault_figure
from sunset.api.pictures import OUTAGE_S, draw_fault_picture
from sunset.cli._options import add_flight_options, add_model_options, run_settings
from sunset.cli._prepare import prepare_flight
from sunset.cli._progress import progress_bar
from sunset.errors import InvalidInputError
from sunset.experiments import RunSpec
from sunset.figures import check_figure
from sunset.perception import load_model
from sunset.scenarios import load_scenario
from sunset.system import Fault, current_system, get_fault
from sunset.tables import aligned


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser(
        "list",
        help="list the catalogue",
        description="List the faults: where each happens, its strength in the suites and the greatest, the failure "
        "that it shows as, and what cures it, cheapest first.",
    )
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    listing.set_defaults(execute=list_faults)
    showing = actions.add_parser("show", help="show one fault and what cures it")
    showing.add_argument("fault", help="its name")
    showing.add_argument("--json", action="store_true", help="print one JSON object")
    showing.add_argument(
        "--figure",
        type=Path,
        metavar="FILE",
        help="draw what it does and what its cure does into a .png, .pdf or .svg: on a frame, or an outage over time",
    )
    showing.add_argument(
        "--frame",
        type=int,
        metavar="N",
        help="of the figure: which frame of the flight, from 0 on (default: the one in its middle)",
    )
    add_model_options(showing)
    showing.set_defaults(execute=show, duration=OUTAGE_S)
    drawing = actions.add_parser(
        "figure",
        help="draw the segmentation's entropy over time, with and without each fault that shows in it",
        description="Run once without a fault and once with each fault that shows in the entropy, as those of F4 do, "
        "and draw the paper's figure. These are five runs of 20 s of flight: it takes a minute or so.",
    )
    drawing.add_argument("--out", type=Path, required=True, metavar="FILE", help="a .png, .pdf or .svg")
    drawing.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the runs")
    add_flight_options(drawing)
    drawing.set_defaults(execute=draw)


def list_faults(arguments: argparse.Namespace) -> None:
    """Print the catalogue."""
    if arguments.json:
        catalogue = [_described(fault) for fault in current_system().faults.values()]
        print(json.dumps({"faults": catalogue}, sort_keys=True))
        return
    header = ("FAULT", "NODE", "KIND", "STRENGTH", "FAILURE", "CURED BY")
    rows = (
        (
            fault.name,
            fault.node,
            fault.kind,
            "-" if fault.limits is None else f"{fault.value}, at most {fault.limits[1]:g}",
            _failure_text(fault),
            fault.cured_by,
        )
        for fault in current_system().faults.values()
    )
    print("\n".join(aligned([header, *rows], left=range(len(header)))))


def show(arguments: argparse.Namespace) -> None:
    """Print one fault, and draw it if that is wanted."""
    fault = get_fault(arguments.fault)
    if arguments.figure is not None:
        settings = run_settings(arguments)
        check_figure(arguments.figure)
        prepare_flight(RunSpec(scenario=load_scenario(fault.name), manager="none", settings=settings))
        with progress_bar("Drawing"):
            draw_fault_picture(fault.name, arguments.figure, settings, arguments.frame)
        print(f"The figure is in {arguments.figure}.", file=sys.stderr)
    elif arguments.frame is not None or arguments.bag is not None or arguments.device != "cpu":
        raise InvalidInputError(
            "--frame, --bag and --device are of a figure: add --figure FILE, or leave them out."
        )
    if arguments.json:
        print(json.dumps(_described(fault), sort_keys=True))
        return
    print(f"{fault.name}: {fault.description}")
    print(f"  failure    {_failure_text(fault)}")
    print(f"  kind       {fault.kind}, in {fault.node}")
    print(f"  injection  {', then '.join(str(step) for step in fault.injection)}")
    if fault.limits is not None:
        print(
            f"  strength   {fault.value} in the suites; above {fault.limits[0]:g} and at most {fault.limits[1]:g}"
        )
        print(f"  severity   {_severities(fault, arguments.model)}")
    print(f"  cured by   {fault.cured_by}{'; by nothing else' if fault.cures else ''}")


def draw(arguments: argparse.Namespace) -> None:
    """Run without and with each fault that shows in the entropy, and draw the figure."""
    settings = run_settings(arguments)
    check_figure(arguments.out)
    nofault = RunSpec(
        scenario=load_scenario("nofault"), manager="none", seed=arguments.seed, settings=settings
    )
    prepare_flight(nofault)
    with progress_bar("Running") as progress:
        draw_fault_figure(arguments.out, settings, arguments.seed, progress)
    print(f"The figure is in {arguments.out}.", file=sys.stderr)


def _severities(fault: Fault, model: str) -> str:
    """Return the strengths of a fault by severity, in words, as a model knows them."""
    card = load_model(model).card
    strengths = card.severities.get(fault.name, ())
    levels = [f"{number}: {one:g}" for number, one in enumerate(strengths, 1) if one is not None]
    return f"{', '.join(levels) or 'not measured'}, with the model {card.name}"


def _failure_text(fault: Fault) -> str:
    return f"{fault.failure}: {current_system().failures[fault.failure].description}"


def _described(fault: Fault) -> dict[str, object]:
    return {
        "name": fault.name,
        "failure": fault.failure,
        "node": fault.node,
        "parameter": fault.parameter,
        "value": fault.value,
        "kind": str(fault.kind),
        "cures": fault.cure_texts,
        "description": fault.description,
    }
