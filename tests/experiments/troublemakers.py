"""Managing systems that fail, each in another way, or do to the interpreter what no other run may notice."""

import importlib
import os
import signal
import sys
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

import sunset.metrics
from sunset.managing import ManagingSystem, NoAdaptation, Symptoms
from sunset.metrics import RunMetrics, Timeline
from sunset.perception import Segmentation, Segmenter


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
                    signal.pause()


class Forks(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        if not os.fork():
            raise SystemExit


class Patches(NoAdaptation):
    def on_start(self) -> None:
        honest = sunset.metrics.score

        def flatter(timeline: Timeline) -> RunMetrics:
            return replace(honest(timeline), iou=1.0, iou_all=1.0)

        for name in ("sunset.metrics", "sunset.metrics.run_metrics", "sunset.experiments.run"):
            vars(importlib.import_module(name))["score"] = flatter


class Poisons(NoAdaptation):
    """Lets every network answer nonsense, in the hope that others look it up."""

    def on_start(self) -> None:
        def answer(segmenter: Segmenter, *_: object) -> Segmentation:
            size = (segmenter.model.card.height, segmenter.model.card.width)
            return Segmentation(np.zeros(size, np.uint8), 0.9)

        vars(sys.modules["sunset.perception.segmenter"])["Segmenter"]._infer = answer


class Moves(NoAdaptation):
    """Works in another folder."""

    def on_start(self) -> None:
        os.chdir("/")
