from sunset.api import Options as Options
from sunset.api import Results as Results
from sunset.api import Run as Run
from sunset.api import agree as agree
from sunset.api import bag_statistics as bag_statistics
from sunset.api import bench as bench
from sunset.api import bundle as bundle
from sunset.api import calibrate_model as calibrate_model
from sunset.api import check_manager as check_manager
from sunset.api import check_split as check_split
from sunset.api import fault_figure as fault_figure
from sunset.api import fault_picture as fault_picture
from sunset.api import generate_split as generate_split
from sunset.api import import_model as import_model
from sunset.api import list_faults as list_faults
from sunset.api import list_managers as list_managers
from sunset.api import list_models as list_models
from sunset.api import list_scenarios as list_scenarios
from sunset.api import list_suites as list_suites
from sunset.api import load as load
from sunset.api import load_model as load_model
from sunset.api import load_scenario as load_scenario
from sunset.api import make_scenario as make_scenario
from sunset.api import measure_curves as measure_curves
from sunset.api import measure_flights as measure_flights
from sunset.api import measure_iou as measure_iou
from sunset.api import plan_bench as plan_bench
from sunset.api import render_flight as render_flight
from sunset.api import report as report
from sunset.api import run as run
from sunset.api import train_model as train_model
from sunset.api import verify as verify
from sunset.api import view as view
from sunset.api import write_figures as write_figures
from sunset.api import write_site as write_site
from sunset.data import FlightPlan as FlightPlan
from sunset.errors import SunsetError as SunsetError
from sunset.managing import ManagingSystem as ManagingSystem
from sunset.managing import Symptoms as Symptoms

__all__ = [
    "FlightPlan",
    "ManagingSystem",
    "Options",
    "Results",
    "Run",
    "SunsetError",
    "Symptoms",
    "__version__",
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

__version__: str
