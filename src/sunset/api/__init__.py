"""What the command line does, one call each; `sunset` has all of it as attributes."""

from sunset.api.agreeing import agree
from sunset.api.catalogue import (
    bag_statistics,
    fault_figure,
    list_faults,
    list_managers,
    list_models,
    list_scenarios,
    list_suites,
    render_flight,
)
from sunset.api.figures import write_figures
from sunset.api.measuring import measure_curves, measure_flights, measure_iou
from sunset.api.options import Manager, Options
from sunset.api.pictures import fault_picture
from sunset.api.publishing import bundle, verify
from sunset.api.results import Results
from sunset.api.running import bench, check_manager, load, make_scenario, plan_bench, report, run
from sunset.api.site import write_site
from sunset.api.splits import check_split, generate_split
from sunset.api.training import calibrate_model, import_model, train_model
from sunset.api.viewing import Run, view
from sunset.perception import load_model
from sunset.scenarios import load_scenario

__all__ = [
    "Manager",
    "Options",
    "Results",
    "Run",
    "agree",
    "bag_statistics",
    "bench",
    "bundle",
    "calibrate_model",
    "check_manager",
    "check_split",
    "fault_figure",
    "fault_picture",
    "generate_split",
    "import_model",
    "list_faults",
    "list_managers",
    "list_models",
    "list_scenarios",
    "list_suites",
    "load",
    "load_model",
    "load_scenario",
    "make_scenario",
    "measure_curves",
    "measure_flights",
    "measure_iou",
    "plan_bench",
    "render_flight",
    "report",
    "run",
    "train_model",
    "verify",
    "view",
    "write_figures",
    "write_site",
]
