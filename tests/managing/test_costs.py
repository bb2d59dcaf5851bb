"""What a managing system says about the costs of its decisions."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import pytest
from tests.managing.test_base import show

from sunset.managing import ManagingSystem, Symptoms
from sunset.system_interfaces.msg import Cost

if TYPE_CHECKING:
    from tests.conftest import World

TOPIC = "/managing_system/cost"


class Paying(ManagingSystem):
    """Asks a model at its first decision."""

    def on_start(self) -> None:
        self.looks = 0

    def adapt(self, symptoms: Symptoms) -> None:
        self.looks += 1
        if self.looks == 1:
            self.spend(model="tiny", tokens_in=120, tokens_out=3, price=0.002)
            self.think(0.5)


def test_costs_and_thoughts_are_published(world: "World") -> None:
    world.start(Paying)
    show(world)
    world.run(1.0)

    said, thought = world.messages[TOPIC]
    assert isinstance(said, Cost)
    assert (said.model, said.tokens_in, said.tokens_out, said.price, said.think_s) == (
        "tiny",
        120,
        3,
        0.002,
        0.0,
    )
    assert (thought.model, thought.tokens_in, thought.price, thought.think_s) == ("", 0, 0.0, 0.5)


def test_a_managing_system_without_costs_publishes_none(world: "World") -> None:
    manager = world.start(Paying)
    manager.looks = 1
    show(world)
    world.run(1.0)

    assert manager.looks > 1
    assert TOPIC not in world.messages
    assert TOPIC not in dict(world.publishers_of("/managing_system"))


@pytest.mark.parametrize(
    ("costs", "expected"),
    [
        ({"model": 3}, "model of a cost must be a text of at most 100 characters, got 3"),
        ({"model": "m" * 101}, "at most 100 characters"),
        ({"tokens_in": -1}, "tokens_in of a cost must be a whole number from 0 to 1000000000, got -1"),
        ({"tokens_out": 2.5}, "tokens_out of a cost must be a whole number"),
        ({"tokens_out": True}, "tokens_out of a cost must be a whole number"),
        ({"price": math.nan}, "price of a cost must be a number from 0 to 1000000, got nan"),
        ({"price": "free"}, "price of a cost must be a number"),
    ],
)
def test_impossible_costs_are_refused(world: "World", costs: Mapping[str, object], expected: str) -> None:
    manager = world.start(Paying)
    with pytest.raises(ValueError, match=expected):
        manager.spend(**costs)  # type: ignore[arg-type]
