"""The commands of the page on live operation can be typed as they stand there."""

import argparse
import re
import shlex
from pathlib import Path

import pytest

from sunset.cli.parser import make_parser

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "live.md").read_text("utf-8")
COMMANDS = re.findall(
    r"^ *(sunset .*)$", "\n".join(re.findall(r"```\n(.*?)```", TEXT, flags=re.DOTALL)), re.MULTILINE
)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_page_is_understood(command: str) -> None:
    _, *words = shlex.split(command, comments=True)

    parsed = make_parser().parse_args(words)

    assert isinstance(parsed, argparse.Namespace)
    assert callable(parsed.execute)


def test_the_page_shows_all_of_the_toolbox() -> None:
    shown = {tuple(command.split()[2:4]) for command in COMMANDS if command.startswith("sunset ros ")}

    assert shown == {
        *(("node", action) for action in ("list", "info")),
        *(("topic", action) for action in ("list", "info", "hz", "echo")),
        *(("param", action) for action in ("list", "get", "set")),
        *(("lifecycle", action) for action in ("nodes", "get", "list", "set")),
        *(("service", action) for action in ("list", "call")),
    }


def test_launch_commands_name_files_and_arguments_that_are_there() -> None:
    for package, file, words in re.findall(r"ros2 launch (\w+) (\S+\.launch\.py)([^\n`]*)", TEXT):
        path = ROOT / "ros2" / package / "launch" / file
        declared = set(re.findall(r'DeclareLaunchArgument\("(\w+)"', path.read_text("utf-8")))
        assert {word.split(":=")[0] for word in words.split() if ":=" in word} <= declared
