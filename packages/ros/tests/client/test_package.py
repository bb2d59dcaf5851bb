"""Code written on the package finds the same modules in rclpy."""

import pkgutil

import sunset_ros


def test_the_modules_have_rclpys_names() -> None:
    modules = {
        info.name for info in pkgutil.iter_modules(sunset_ros.__path__) if not info.name.startswith("_")
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
            "signals",
            "subscription",
            "task",
            "time",
            "timer",
        ),
    }
    own = {
        *("arguments", "commands", "errors", "generator", "interfaces", "interruption", "names", "rmw"),
        *("seeding", "testing", "texts"),
    }
    assert modules == of_rclpy | own
