"""Managing systems that fail, each in another way, or do to the interpreter what no other run may notice."""

import os
import sys
from contextlib import suppress
from typing import Any

from sunset.managing import ManagingSystem, NoAdaptation, Symptoms


class RaisesInConstructor(NoAdaptation):
    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        raise LookupError("nothing to begin with")


class RaisesInOnStart(NoAdaptation):
    def on_start(self) -> None:
        raise LookupError("nothing to start with")


class RaisesInAdapt(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        raise KeyboardInterrupt


class Exits(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        sys.exit("enough")


class EndsItsProcess(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        os._exit(0)


class Hangs(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        while True:
            with suppress(BaseException):
                while True:
                    pass


class Forks(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        if not os.fork():
            raise SystemExit


class Patches(NoAdaptation):
    def on_start(self) -> None:
        def flatter(*_: object) -> None:
            raise ZeroDivisionError("patched")

        for name in ("sunset.metrics.score", "sunset.experiments.run"):
            vars(sys.modules[name])["score"] = flatter
