"""One managing system for each adaptation of the catalogue: it does just that, once, at a fixed time.

`adapters.py:Adapt_07` does the adaptation with index 7; `adapters.py:Cure_image_degradation` the only cure that takes
two adaptations.
"""

from collections.abc import Sequence

from sunset.managing import ManagingSystem, Symptoms
from sunset.system import Adaptation, AdaptationKind, current_system

ADAPTATIONS = current_system().adaptations
FAULTS = current_system().faults

AFTER_S = 1.5
"""When to adapt, counted from the first segmentation: 0.5 s of warm-up, then 1 s of symptoms."""


class _Adapter(ManagingSystem):
    adaptations: Sequence[Adaptation] = ()

    def on_start(self) -> None:
        self.first: int | None = None
        self.done = False

    def adapt(self, symptoms: Symptoms) -> None:
        now = self.get_clock().now().nanoseconds
        if self.first is None and symptoms.frequency("segmentation") > 0:
            self.first = now
        if self.done or self.first is None or now - self.first < AFTER_S * 1e9:
            return
        self.done = True
        for adaptation in self.adaptations:
            self.carry_out(adaptation)

    def carry_out(self, adaptation: Adaptation) -> None:
        if adaptation.kind in {AdaptationKind.SET_PARAMETER, AdaptationKind.CHANGE_TOPIC}:
            assert adaptation.value is not None
            self.set_parameter(adaptation.node, adaptation.parameter, adaptation.value)
        else:
            getattr(self, adaptation.kind)(adaptation.node)


for _index, _adaptation in enumerate(ADAPTATIONS):
    _name = f"Adapt_{_index:02d}"
    globals()[_name] = type(_name, (_Adapter,), {"adaptations": (_adaptation,), "__doc__": str(_adaptation)})


class CureImageDegradation(_Adapter):
    """The cure of image_degradation: activate the enhancement, and let the fusion use it."""

    adaptations = FAULTS["image_degradation"].cures[0]
