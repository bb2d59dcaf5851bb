"""What the package exports, and that code written on it finds the same names in rclpy."""

import doctest
import importlib
import pkgutil

import sunset.ros


def test_every_module_exports_what_it_says() -> None:
    for info in pkgutil.walk_packages(sunset.ros.__path__, "sunset.ros."):
        module = importlib.import_module(info.name)
        for name in module.__all__:
            assert hasattr(module, name), f"{info.name}.{name}"


def test_the_modules_have_rclpys_names() -> None:
    modules = {
        info.name for info in pkgutil.iter_modules(sunset.ros.__path__) if not info.name.startswith("_")
    }
    of_rclpy = {
        *("callback_groups", "client", "clock", "context", "exceptions", "executors", "lifecycle", "logging"),
        *(
            "duration",
            "node",
            "parameter",
            "publisher",
            "qos",
            "service",
            "subscription",
            "task",
            "time",
            "timer",
        ),
    }
    own = {"arguments", "names"}
    assert modules == of_rclpy | own


def test_the_examples_in_docstrings_are_true() -> None:
    modules = [
        importlib.import_module(info.name)
        for info in pkgutil.walk_packages(sunset.ros.__path__, "sunset.ros.")
    ]
    results = [doctest.testmod(module) for module in modules]
    assert sum(result.failed for result in results) == 0
    assert sum(result.attempted for result in results) > 0
