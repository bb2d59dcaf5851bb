"""Samples that nobody in their right mind would send: absurd ones, malformed ones, noise."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from rmw.peer import Peer
from sunset_ros.interfaces import FieldType, Message, field_types, get_message, serialize
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

Random = np.random.Generator

WORDS = (
    *(
        "",
        "flag",
        "image.shift",
        "use_sim_time",
        "configure",
        "activate",
        "deactivate",
        "cleanup",
        "shutdown",
    ),
    *("\x00", "ä" * 50, "x" * 1000, "bgr8", "16UC1", "8UC1", "camera", "true", "nan", "segmentation_entropy"),
    *(
        "image_degradation",
        "autofocus_needed",
        "topic_camera_input",
        "modality",
        "gpu_failure",
        "rgb_enhanced",
    ),
)
ENCODINGS = {"bgr8": 3, "16UC1": 2, "8UC1": 1}
HUGE = 10_000
"""Characters or pixels of what is huge, which one in a hundred is."""


def targets(peer: Peer) -> dict[str, tuple[str, type[Message]]]:
    """Return the DDS type and the message of every topic and service on which somebody listens."""
    found: dict[str, tuple[str, type[Message]]] = {}
    for reader in peer.every_reader():
        match = re.fullmatch(r"(\w+)::(\w+)::dds_::(\w+)_", reader.type_name)
        if match and not reader.topic_name.startswith("ros_discovery"):
            found[reader.topic_name] = (reader.type_name, get_message("/".join(match.groups())))
    return found


def samples(kind: type[Message], random: Random, *, service: bool) -> Iterator[bytes]:
    """Yield samples without end, of every one of the `KINDS` in turn.

    Args:
        kind: what the topic's readers expect.
        random: decides.
        service: whether it is a service's topic, whose samples have a header.
    """
    while True:
        for make in KINDS:
            body = serialize(random_message(kind, random))
            yield make(body[:4] + (random.bytes(16) if service else b"") + body[4:], random)


def _cut(whole: bytes, random: Random) -> bytes:
    return padded(whole[: 4 + int(random.integers(len(whole) - 3))])


def _spoilt(whole: bytes, random: Random) -> bytes:
    spoilt = bytearray(whole)
    for position in random.integers(4, len(whole), 3):
        spoilt[position] ^= 1 << int(random.integers(8))
    return bytes(spoilt)


def _oversized(whole: bytes, random: Random) -> bytes:
    """Say that there are more elements or characters than there are."""
    spoilt = bytearray(whole)
    position = 4 * int(random.integers(1, len(whole) // 4))
    spoilt[position : position + 4] = random.choice((b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\x01\0"))
    return bytes(spoilt)


def _noise(whole: bytes, random: Random) -> bytes:
    return whole[:4] + padded(random.bytes(int(random.integers(1, 200))))


KINDS: tuple[Callable[[bytes, Random], bytes], ...] = (
    lambda whole, _: whole,
    _cut,
    _spoilt,
    _oversized,
    lambda whole, random: whole + random.bytes(4 * int(random.integers(1, 10))),
    _noise,
    lambda whole, random: random.bytes(2) + whole[2:],  # another encapsulation
    lambda whole, random: whole[:2] + random.bytes(2) + whole[4:],  # other options
    lambda whole, random: whole[: 4 * int(random.integers(3))],  # nothing, or next to it
)


def padded(data: bytes) -> bytes:
    """Return data with padding up to a multiple of 4 bytes."""
    return data + bytes(-len(data) % 4)


def random_message(kind: type[Message], random: Random) -> Message:
    """Return a message with any values that its definition allows; half of the images are such."""
    if kind is Image and random.integers(2):
        return random_image(random)
    return kind(**{name: random_value(field, random) for name, field in field_types(kind).items()})


def random_image(random: Random) -> Image:
    """Return an image of any size and time that has as much data as it says."""
    encoding = str(random.choice(list(ENCODINGS)))
    height, width = (int(size) for size in random.integers(0, 20, 2))
    if not random.integers(100):
        height, width = 100, HUGE // 100
    step = width * ENCODINGS[encoding]
    stamp = Time(sec=int(random.choice((-1, 0, 5, 2**31 - 1))), nanosec=int(random.choice((0, 2**32 - 1))))
    data = random.integers(0, 256, height * step, np.uint8)
    return Image(
        header=Header(stamp=stamp), height=height, width=width, encoding=encoding, step=step, data=data
    )


def random_value(kind: FieldType, random: Random) -> Any:
    """Return any value that a field may have."""
    if kind.is_array:
        size = kind.size if kind.size is not None else int(random.integers(0, 4))
        values = [random_value(FieldType(kind.base, kind.string_bound), random) for _ in range(size)]
        return np.array(values, kind.base) if kind.is_numpy else values
    if kind.is_message:
        return random_message(get_message(kind.base), random)
    if kind.base == "byte":
        return random.bytes(1)
    choices = edges(kind, random)
    return choices[random.integers(len(choices))]


def edges(kind: FieldType, random: Random) -> list[Any]:
    """Return values of a primitive type that tend to be forgotten."""
    if kind.base == "string":
        if not random.integers(100):
            return ["x" * HUGE]
        new = random.bytes(4).hex()
        return [word[: kind.string_bound or None] for word in (*WORDS, new)]
    if kind.base == "bool":
        return [False, True]
    if kind.base.startswith("float"):
        return [0.0, 1.0, -1.5, float(np.finfo(kind.base).max), np.nan, np.inf]
    limits = np.iinfo(kind.base)
    return [0, 1, 2, 3, 4, 5, int(limits.min), int(limits.max)]
