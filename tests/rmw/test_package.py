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
