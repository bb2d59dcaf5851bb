"""An extension whose node does what the variable LIGHT_METER says: it fails, each time in another way."""

import os
import sys

from sunset.nodes import AdaptiveNode
from sunset.system import Extension, NodeDescription


def fail(where: str) -> None:
    match os.environ["LIGHT_METER"].removeprefix(where):
        case " raises":
            raise ValueError("mine")
        case " exits":
            sys.exit("enough")
        case " ends its process":
            os._exit(3)
        case " loops":
            while True:
                pass


class LightMeter(AdaptiveNode):
    node_name = "light_meter"

    def set_up(self) -> None:
        fail("set_up")
        self.create_timer(1.0, self.on_timer)

    def on_timer(self) -> None:
        fail("on_timer")


EXTENSION = Extension(nodes=(NodeDescription("light_meter", LightMeter, inputs=()),))
