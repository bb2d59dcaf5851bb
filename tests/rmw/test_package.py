import doctest
import importlib
import pkgutil

import sunset.rmw


def test_every_module_exports_what_it_says() -> None:
    for info in pkgutil.iter_modules(sunset.rmw.__path__, "sunset.rmw."):
        module = importlib.import_module(info.name)
        assert module.__all__ == sorted(module.__all__, key=lambda name: (not name.isupper(), name)), (
            info.name
        )
        for name in module.__all__:
            assert hasattr(module, name), f"{info.name}.{name}"


def test_the_examples_in_docstrings_are_true() -> None:
    modules = [
        importlib.import_module(info.name)
        for info in pkgutil.walk_packages(sunset.rmw.__path__, "sunset.rmw.")
    ]
    results = [doctest.testmod(module) for module in modules]
    assert sum(result.failed for result in results) == 0
    assert sum(result.attempted for result in results) > 0
