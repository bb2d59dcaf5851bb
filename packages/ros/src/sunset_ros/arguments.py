"""The arguments after `--ros-args`: remappings, parameters, parameter files.

See https://docs.ros.org/en/jazzy/How-To-Guides/Node-arguments.html for their meaning.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from sunset_ros._parameter_files import Override, matches, parse_value, read_parameter_file
from sunset_ros.exceptions import NameValidationException, UnknownROSArgsError
from sunset_ros.logging import LoggingSeverity
from sunset_ros.names import RemapRule, validate_namespace, validate_node_name, validate_topic_name
from sunset_ros.parameter import Parameter


@dataclass(slots=True)
class Arguments:
    """The arguments after `--ros-args`."""

    remaps: list[RemapRule] = field(default_factory=list)  #: in their order; the first that matches is used
    overrides: list[Override] = field(default_factory=list)  #: likewise, but the last that matches is used
    log_level: LoggingSeverity | None = None  #: below which nothing is logged; None if not given
    log_to_stderr: bool | None = None  #: None if not given
    log_to_rosout: bool = True
    others: list[str] = field(default_factory=list)  #: all other arguments

    @classmethod
    def parse(cls, arguments: Sequence[str]) -> "Arguments":
        """Read a command line, as in `sys.argv`; ROS's own arguments stand between `--ros-args` and `--` or the end.

        Raises:
            UnknownROSArgsError: an argument after `--ros-args` is unknown or malformed.
            ParameterError: a parameter file cannot be read or is malformed.
        """
        result = cls()
        words = iter(arguments)
        for word in words:
            if word == "--ros-args":
                result._parse_section(words)
            else:
                result.others.append(word)
        return result

    def _parse_section(self, words: Iterator[str]) -> None:
        for word in words:
            if word == "--":
                return
            if word in _FLAGS:
                name, value = _FLAGS[word]
                setattr(self, name, value)
            elif word in _OPTIONS:
                option_value = next(words, None)
                if option_value is None:
                    raise UnknownROSArgsError(f"ROS argument {word} needs a value after it.")
                _OPTIONS[word](self, option_value)
            elif word != "--ros-args":
                known = ", ".join([*_OPTIONS, *_FLAGS])
                raise UnknownROSArgsError(
                    f"ROS argument {word!r} is unknown; after --ros-args may come {known}."
                )

    def _add_remap(self, text: str) -> None:
        source, separator, target = text.partition(":=")
        node, _, source = source.rpartition(":")
        if not separator or not source or not target:
            raise UnknownROSArgsError(f"A remapping must be FROM:=TO or NODE:FROM:=TO, got {text!r}.")
        source = "__node" if source == "__name" else source
        try:
            if source == "__node":
                validate_node_name(target)
            elif source == "__ns":
                validate_namespace(target)
            else:
                validate_topic_name(source)
                validate_topic_name(target)
            if node:
                validate_node_name(node)
        except NameValidationException as error:
            raise UnknownROSArgsError(f"The remapping {text!r} cannot be used: {error}") from error
        self.remaps.append(RemapRule(source, target, node or None))

    def _add_parameter(self, text: str) -> None:
        name, separator, value = text.partition(":=")
        node, _, name = name.rpartition(":")
        if not separator or not name:
            raise UnknownROSArgsError(f"A parameter must be NAME:=VALUE or NODE:NAME:=VALUE, got {text!r}.")
        parameter = Parameter(name, value=parse_value(value, f"parameter {name!r}"))
        self.overrides.append(Override(f"/**/{node}" if node else "/**", parameter))

    def _add_file(self, text: str) -> None:
        self.overrides += read_parameter_file(Path(text))

    def _set_level(self, text: str) -> None:
        name = text.rpartition(":=")[2].upper()
        name = "WARN" if name == "WARNING" else name
        if name not in LoggingSeverity.__members__:
            levels = ", ".join(LoggingSeverity.__members__)
            raise UnknownROSArgsError(f"A log level must be one of {levels}, got {text!r}.")
        self.log_level = LoggingSeverity[name]


_OPTIONS: dict[str, Callable[[Arguments, str], None]] = {
    "-r": Arguments._add_remap,  # noqa: SLF001  the table belongs to the class
    "--remap": Arguments._add_remap,  # noqa: SLF001  likewise
    "-p": Arguments._add_parameter,  # noqa: SLF001  likewise
    "--param": Arguments._add_parameter,  # noqa: SLF001  likewise
    "--params-file": Arguments._add_file,  # noqa: SLF001  likewise
    "--log-level": Arguments._set_level,  # noqa: SLF001  likewise
}
_FLAGS: dict[str, tuple[str, bool]] = {
    "--enable-rosout-logs": ("log_to_rosout", True),
    "--disable-rosout-logs": ("log_to_rosout", False),
    "--enable-stdout-logs": ("log_to_stderr", True),
    "--disable-stdout-logs": ("log_to_stderr", False),
}


def find_overrides(arguments: Sequence[Arguments], node: str) -> list[Parameter]:
    """Return the parameters that are set for a node of this full name; the last, of the first arguments, win."""
    return [
        override.parameter
        for each in reversed(arguments)
        for override in each.overrides
        if matches(override.nodes, node)
    ]
