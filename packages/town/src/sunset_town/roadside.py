"""Things along the streets: lamps, lights, signs, stops, trees, parked cars, bridge rails."""

from itertools import cycle
from typing import Final

import numpy as np

from sunset_town.furnish import Builder
from sunset_town.layout import PAVEMENT_M, Street
from sunset_town.paving import NARROW_M
from sunset_town.relief import CROWN_M
from sunset_town.terrain import rail_spans

BRIDGE_M: Final = 12.0
"""Least distance of bus stops from the river's water."""


def furnish_streets(builder: Builder) -> None:
    """Furnish every street between its crossings, and the crossings themselves."""
    for street in builder.plan.streets:
        for before, after in builder.plan.stretches(street):
            stretch = (before.at + before.width / 2, after.at - after.width / 2)
            _lamps(builder, street, stretch)
            _planting(builder, street, stretch)
            _crossing_signs(builder, street, after, stretch[1], 1)
            _crossing_signs(builder, street, before, stretch[0], -1)
            if street.width > NARROW_M and builder.chance(0.75 if street.avenue else 0.25):
                _stop(builder, street, stretch)
        if street.axis == 1:
            _bridge(builder, street)


def furnish_railway(builder: Builder) -> None:
    """Girders and rails on both edges of the railway's bridges."""
    relief = builder.plan.relief
    for start, end in rail_spans(builder.plan):
        for side in (-1, 1):
            u = relief.rail + side * (CROWN_M - 0.2)
            ends = (u, start), (u, end)
            builder.line("pier", *ends, 1.7, level=lambda uv: float(relief.railway(uv[1])) - 1.1)
            builder.line("rail guard", *ends, 0.6, level=lambda uv: float(relief.railway(uv[1])) + 0.6)


def _lamps(builder: Builder, street: Street, stretch: tuple[float, float]) -> None:
    places = np.arange(stretch[0] + 8, stretch[1] - 6, 15.0).tolist()
    for at, side in zip(places, cycle((1, -1)), strict=False):
        uv = street.points(at, side * (street.width / 2 + 0.5))
        turn = np.pi if side > 0 else 0.0  # to face the carriageway
        builder.put("lamp", uv, axis=1 - street.axis, turn=turn)


def _planting(builder: Builder, street: Street, stretch: tuple[float, float]) -> None:
    """Trees on an avenue's pavements; parked cars, some skips, half on a side street's pavement."""
    rng = builder.rng
    for side in (-1, 1):
        edge = street.width / 2
        if street.avenue:
            for at in np.arange(stretch[0] + 11, stretch[1] - 9, 11.0).tolist():
                uv = street.points(at, side * (edge + PAVEMENT_M + 0.4))
                builder.tree(uv, rng.uniform(6, 9), int(rng.integers(4)))
            continue
        if builder.chance(0.35):
            continue
        for at in np.arange(stretch[0] + 11, stretch[1] - 10, 6.2).tolist():
            chance = rng.random()
            uv = street.points(at, side * (edge + 0.95))
            if chance < 0.55:
                builder.car(uv, street.axis)
            elif chance < 0.6:
                builder.skip(uv, axis=street.axis)


def _crossing_signs(builder: Builder, street: Street, other: Street, at: float, direction: int) -> None:
    """Traffic lights where an avenue takes part, else a sign, to the right of approaching traffic."""
    rng = builder.rng
    side = direction * street.right
    uv = street.points(at - direction * 0.6, side * (street.width / 2 + 0.7))
    turn = 0.0 if direction > 0 else np.pi
    if street.avenue or other.avenue:
        builder.put("traffic light", uv, axis=street.axis, turn=turn)
    elif builder.chance(0.6):
        tint = ((0.8, 0.12, 0.1), (0.1, 0.25, 0.7), (0.9, 0.75, 0.1))[int(rng.integers(3))]
        builder.put("sign", uv, axis=street.axis, turn=turn, tint=tint)
    if street.avenue and builder.chance(0.35):
        back = street.points(at - direction * 14, side * (street.width / 2 + 0.8))
        builder.put("gantry", back, axis=street.axis, turn=turn)


def _stop(builder: Builder, street: Street, stretch: tuple[float, float]) -> None:
    """A bus stop in the middle of a stretch, facing the carriageway, unless it is a bridge."""
    middle = (stretch[0] + stretch[1]) / 2 + 3
    side = 1 if builder.chance(0.5) else -1
    uv = street.points(middle, side * (street.width / 2 + 1.9))
    if builder.plan.relief.off_water(uv) < BRIDGE_M:
        return
    facing = 0.0 if (side > 0) == (street.axis == 0) else np.pi
    builder.put("bus stop", uv, axis=street.axis, turn=facing)


def _bridge(builder: Builder, street: Street) -> None:
    """Rails on both edges of the bridge that carries a street over the river."""
    relief = builder.plan.relief
    river, half = float(relief.river_v(street.at)), relief.river_width / 2 + 7
    for side in (-1, 1):
        u = street.at + side * (street.width / 2 + PAVEMENT_M - 0.2)
        ends = (u, river - half), (u, river + half)
        builder.line("pier", *ends, 1.25, level=lambda uv: float(relief.streets(uv)) - 1.2)
        builder.line("rail guard", *ends, 1.1)
        for uv in ends:
            builder.put("pier", uv, scale=(1.2, 1.2, 1.8))
