"""Messages with random content, for every type that there is."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import sunset_ros.interfaces
from sunset_ros.interfaces import FieldType, Message, field_types, get_message
from sunset_ros.seeding import generator

INTERFACES = Path(sunset_ros.interfaces.__file__).parent
TEXTS = ("", "a", "ab", "abc", "camera/driver", "größer als 5 µm", "🚁", "x" * 200)


def all_names() -> list[str]:
    """Return the full name of every message, requests and responses included."""
    names = [f"{path.parts[-3]}/msg/{path.stem}" for path in INTERFACES.glob("*/msg/*.msg")]
    for path in INTERFACES.glob("*/srv/*.srv"):
        names += [f"{path.parts[-3]}/srv/{path.stem}_{part}" for part in ("Request", "Response")]
    return sorted(names)


def random_message(kind: type[Message], rng: np.random.Generator) -> Message:
    message = kind()
    for name, field in field_types(kind).items():
        setattr(message, name, random_value(field, rng))
    return message


def random_value(field: FieldType, rng: np.random.Generator) -> object:
    if not field.is_array:
        return random_element(field, rng)
    size = field.size if field.size is not None else int(rng.integers(1 + min(5, field.limit or 5)))
    if field.is_numpy:
        return random_numbers(field, rng, size)
    return [random_element(field, rng) for _ in range(size)]


def random_element(field: FieldType, rng: np.random.Generator) -> object:
    if field.is_message:
        return random_message(get_message(field.base), rng)
    if field.base == "string":
        return str(rng.choice(TEXTS))
    if field.base == "bool":
        return bool(rng.integers(2))
    if field.base == "byte":
        return rng.bytes(1)
    return random_numbers(field, rng, 1)[0].item()


def random_numbers(field: FieldType, rng: np.random.Generator, size: int) -> np.ndarray:
    dtype = np.dtype(field.base)
    if dtype.kind == "f":
        return rng.normal(size=size, scale=1e3).astype(dtype)
    return np.frombuffer(rng.bytes(size * dtype.itemsize), dtype)


@pytest.fixture(params=all_names())
def kind(request: pytest.FixtureRequest) -> type[Message]:
    return get_message(request.param)


@pytest.fixture
def examples(kind: type[Message]) -> list[Message]:
    """The default message, and twenty with random content."""
    return [kind(), *(random_message(kind, generator(1, kind.__ros_name__, index)) for index in range(20))]


@pytest.fixture
def make_random() -> Callable[[type[Message], int], Message]:
    return lambda kind, seed: random_message(kind, generator(seed, kind.__ros_name__))
