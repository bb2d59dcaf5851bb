"""The messages of the managed system, which SUNSET adds to those of the client library."""

import re
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import sunset
from sunset_ros.generator.modules import generate
from sunset_ros.interfaces import (
    deserialize,
    get_message,
    get_service,
    message_definition,
    serialize,
    type_hash,
)

SOURCE = Path(sunset.__file__).parent
FILES = sorted((SOURCE / "system_interfaces").rglob("*.msg"))


def test_the_modules_are_those_of_the_definitions() -> None:
    modules = generate(SOURCE, "sunset")
    assert {path.partition("/")[0] for path in modules} == {"system_interfaces"}
    for path, text in modules.items():
        assert (SOURCE / path).read_text(encoding="utf-8") == text, f"run scripts/generate_interfaces: {path}"


@pytest.mark.parametrize("name", [f"system_interfaces/msg/{file.stem}" for file in FILES])
def test_a_message_is_known_by_name_and_has_the_hash_of_an_independent_implementation(name: str) -> None:
    kind = get_message(name)
    store = get_typestore(Stores.EMPTY)
    parsed = get_types_from_msg(re.sub(r"\bchar\b", "uint8", message_definition(kind)), name)
    constants, fields = parsed.pop(name)
    store.fielddefs.update(parsed)
    store.fielddefs[name] = (
        constants,
        fields or get_typestore(Stores.ROS2_JAZZY).fielddefs["std_msgs/msg/Empty"][1],
    )

    assert type_hash(kind) == store.hash_rihs01(name)
    assert deserialize(serialize(kind()), kind) == kind()


def test_services_are_known_by_name() -> None:
    for file in (SOURCE / "system_interfaces").rglob("*.srv"):
        assert get_service(f"system_interfaces/srv/{file.stem}").__name__ == file.stem
