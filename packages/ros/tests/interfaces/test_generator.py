import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import sunset_ros.interfaces
from sunset_ros.errors import InterfaceError
from sunset_ros.generator.modules import generate

INTERFACES = Path(sunset_ros.interfaces.__file__).parent


def package(tmp_path: Path, text: str, kind: str = "msg") -> Path:
    folder = tmp_path / "pkg" / kind
    folder.mkdir(parents=True)
    (folder / f"Own.{kind}").write_text(text)
    return tmp_path


def load(definitions: Path) -> ModuleType:
    module = ModuleType("generated")
    exec(generate(definitions, "own")["pkg/msg/__init__.py"], module.__dict__)  # noqa: S102  the code under test
    return module


def test_the_modules_in_the_package_are_those_of_the_definitions() -> None:
    for path, text in generate(INTERFACES, "sunset_ros.interfaces").items():
        assert (INTERFACES / path).read_text() == text, path


def test_no_module_is_left_over_from_a_definition_that_is_gone() -> None:
    modules = {path.relative_to(INTERFACES).as_posix() for path in INTERFACES.glob("*/**/__init__.py")}
    assert modules == set(generate(INTERFACES, "sunset_ros.interfaces"))


def test_the_command_names_and_writes_modules_that_differ_from_their_definitions(tmp_path: Path) -> None:
    folder = package(tmp_path, "std_msgs/Header header\nOther other\n")
    (folder / "pkg" / "msg" / "Other.msg").write_text("uint8 a\n")
    command = [sys.executable, "-m", "sunset_ros.generator", str(folder), "own"]

    def output() -> str:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    files = ["pkg/msg/__init__.py", "pkg/__init__.py"]
    assert output() == "".join(f"written: {file}\n" for file in files)
    assert output() == ""


def test_defaults_arrays_and_padding_of_any_definition_work(tmp_path: Path) -> None:
    text = """
    uint8 a 7
    int64 b -1
    bool c true
    uint16 d
    float64 e 2.5
    string f "x"
    byte[3] g
    bool[2] h
    string<=4[2] i
    int16[3] j [1, 2, 3]
    uint16[] k [4]
    string[] l ["p", "q"]
    int8 m
    """
    own = load(package(tmp_path, text)).Own
    message = own()
    assert (message.a, message.b, message.c, message.e, message.f) == (7, -1, True, 2.5, "x")
    assert (message.g, message.h, message.i) == ([b"\0"] * 3, [False] * 2, ["", ""])
    assert (message.j.tolist(), message.k.tolist(), message.l) == ([1, 2, 3], [4], ["p", "q"])
    assert message.j.dtype == np.int16
    other = own(a=1, d=9, g=[b"1", b"2", b"3"], h=[True, False], i=["ab", "c"], m=-3)
    payload = sunset_ros.interfaces.serialize(other)
    assert sunset_ros.interfaces.deserialize(payload, own) == other


def test_messages_of_a_package_come_after_those_that_they_use(tmp_path: Path) -> None:
    folder = package(tmp_path, "Zebra zebra\nZebra[2] more\n") / "pkg" / "msg"
    (folder / "Zebra.msg").write_text("uint8 stripes 3\n")
    message = load(tmp_path).Own()
    assert (message.zebra.stripes, len(message.more)) == (3, 2)


@pytest.mark.parametrize("name", ["class", "copy", "self"])
def test_a_field_that_cannot_be_an_attribute_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InterfaceError, match=f"pkg/msg/Own has a field '{name}'"):
        generate(package(tmp_path, f"bool {name}\n"), "own")
