"""Commands of programs: their words, their files, and what is wrong with those that cannot be started."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from sunset.errors import ManagerError
from sunset.managing import checksum, load_manager, parse_command, split_label
from sunset.managing.program import Program
from sunset.managing.sources import source_files


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("print()")
    (tmp_path / "my data.txt").write_text("1")
    (tmp_path / "run.sh").write_text("#!/bin/sh\n")
    (tmp_path / "run.sh").chmod(0o755)
    for name in ("main.py", "part/helper.py", "part/__pycache__/helper.pyc"):
        (tmp_path / "package" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "package" / name).write_text(name)
    return tmp_path


def test_words_are_those_of_a_shell_and_files_are_found_from_anywhere(folder: Path) -> None:
    command = parse_command("exec:sh -c 'a b' mine.py --x=1 'my data.txt'")
    assert command.words == (
        str(Path(shutil.which("sh") or "").absolute()),
        *("-c", "a b", f"{folder}/mine.py", "--x=1", f"{folder}/my data.txt"),
    )
    assert command.files == (folder / "mine.py", folder / "my data.txt")


@pytest.mark.parametrize(
    ("spec", "files"),
    [
        ("exec:./run.sh", ["run.sh"]),
        ("exec:sh run.sh", ["run.sh"]),
        ("exec:/bin/sh run.sh", ["run.sh"]),
        ("exec:./run.sh package", ["package/main.py", "package/part/helper.py", "run.sh"]),
        ("exec:sh", []),
    ],
)
def test_a_checksum_is_of_what_the_command_names(spec: str, files: list[str], folder: Path) -> None:
    made = load_manager(spec)
    assert issubclass(made, Program)
    sources = source_files(spec)
    assert sources == tuple(folder / file for file in files)
    before = checksum(spec)
    assert bool(before) == bool(files)
    if files:
        (folder / files[0]).write_text("#!/bin/sh\n# another one")
        assert checksum(spec) != before


@pytest.mark.usefixtures("folder")
def test_a_command_is_resolved_for_another_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    commands = ["exec:sh 'my data.txt'", "exec:./run.sh a package"]
    known = [parse_command(spec) for spec in commands]
    resolved = [str(command) for command in known]
    monkeypatch.chdir("/")
    monkeypatch.setenv("PATH", "")
    assert [parse_command(spec) for spec in resolved] == known


@pytest.mark.parametrize(
    ("spec", "told"),
    [
        ("exec:", "a command must follow; name it as exec:PROGRAM ARGUMENTS"),
        ("exec:   ", "a command must follow"),
        ("exec:sh 'a", "no closing quotation"),
        ("exec:no-such-program x", "there is no program no-such-program on PATH"),
        ("exec:./none.sh", r"there is no file \./none\.sh"),
        ("exec:python3 none.py --fast", r"there is no file none\.py"),
        ("exec:run.sh", r"a program that is not on PATH is named by its path, exec:\./run\.sh"),
        ("exec:./mine.py", r"let it be run \(chmod \+x \./mine\.py\), or name what runs it, as exec:python3"),
        ("exec:./package", r"there is no file \./package"),
        ("exec:./run.sh /usr", "names the folder /usr, which holds more than 1000 files"),
        ("exec:./run.sh \x1b[2J", "contains an unprintable character"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_a_command_that_cannot_be_started_is_refused(spec: str, told: str) -> None:
    with pytest.raises(ManagerError, match=told) as failure:
        load_manager(spec)
    assert "\n" not in str(failure.value)


def script(file: Path, text: str) -> Path:
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    file.chmod(0o755)
    return file


def test_the_python_that_a_shim_runs_is_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shim = script(folder / "shims" / "python3", f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    monkeypatch.setenv("PATH", f"{shim.parent}:{os.environ['PATH']}")
    command = parse_command("exec:python3 mine.py")
    assert command.words == (sys.executable, str(folder / "mine.py"))
    assert command.files == (folder / "mine.py",)


@pytest.mark.parametrize(("line", "options"), [("python3", ()), ("-S python3 -u", ("-u",))])
def test_what_a_script_asks_for_is_looked_up_before_it_is_started(
    line: str, options: tuple[str, ...], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shim = script(folder / "shims" / "python3", f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    mine = script(folder / "mine", f"#!/usr/bin/env {line}\n")
    monkeypatch.setenv("PATH", f"{shim.parent}:{os.environ['PATH']}")
    command = parse_command("exec:./mine package")
    assert command.words == (sys.executable, *options, str(mine), str(folder / "package"))
    assert parse_command(str(command)) == command


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("shims/python3", "#!/bin/sh\nexit 3\n", "does not say which Python it runs; name that by its path"),
        ("shims/node", "#!/bin/sh\n", "only looks for the program node and runs it"),
        ("mine", "#!/usr/bin/env no-such-program\n", "there is no program no-such-program on PATH"),
    ],
)
def test_what_cannot_be_started_behind_walls_is_refused_before(
    name: str, text: str, told: str, tmp_path: Path
) -> None:
    program = script(tmp_path / name, text)
    with pytest.raises(ManagerError, match=told):
        parse_command(f"exec:{program}")


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("mine=exec:./run.sh a=b", ("mine", "exec:./run.sh a=b")),
        ("exec:./run.sh a=b", ("", "exec:./run.sh a=b")),
    ],
)
def test_a_label_stands_before_exec(text: str, parts: tuple[str, str]) -> None:
    assert split_label(text) == parts
