"""Extensions that are wrong get one sentence; what was loaded for a while is gone after it."""

from pathlib import Path

import pytest

from sunset.cli import main
from sunset.errors import ExtensionError
from sunset.system import current_system, extended_system, load_extension, loaded_extensions

HEAD = "from sunset.nodes import AdaptiveNode\nfrom sunset.system import *\n"
SONAR = HEAD + "class Sonar(AdaptiveNode):\n    node_name = 'sonar'\n"


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (
            "import sonar_of_nobody",
            "cannot be imported: it raised ModuleNotFoundError: No module named 'sonar_of",
        ),
        ("x = (", ", line 1 cannot be imported: it raised SyntaxError"),
        ("raise SystemExit", "cannot be imported: it raised SystemExit"),
        ("x = 1", "must have an Extension as EXTENSION, got NoneType"),
        (
            HEAD + "EXTENSION = Extension(nodes='sonar')",
            "The nodes of an extension must be a tuple of NodeDescr",
        ),
        (
            HEAD + "EXTENSION = Extension(nodes=(NodeDescription('sonar', None, ()),))",
            "The node sonar needs a class",
        ),
        (
            HEAD + "EXTENSION = Extension(nodes=(NodeDescription('sonar', 'no:Sonar', ()),))",
            "The class no:Sonar of the node sonar cannot be imported: No module named 'no'",
        ),
        (
            HEAD + "EXTENSION = Extension(nodes=(NodeDescription('sonar', 'sunset.nodes:Sonar', ()),))",
            "cannot be imported: module 'sunset.nodes' has no attribute 'Sonar'",
        ),
        (
            SONAR + "EXTENSION = Extension(nodes=(NodeDescription('camera', Sonar, ()),))",
            "The name of the node 'camera' is taken",
        ),
        (
            SONAR + "EXTENSION = Extension(nodes=(NodeDescription('sonar', Sonar, ('echo',)),))",
            "No node publishes on the topic /managed_subsystem/echo",
        ),
        (
            SONAR + "EXTENSION = Extension(nodes=(NodeDescription('sonar', Sonar, ('echo',), ('echo',)),))",
            "The wiring of the nodes has a cycle: sonar feeds sonar",
        ),
        (
            HEAD + "EXTENSION = Extension(failures=(Failure('F6', 'a', 'b', 'c', signal='sonar_echo'),))",
            "The failure F6 refers to the signal 'sonar_echo', which is not there",
        ),
        (
            HEAD + "EXTENSION = Extension(signals=(Signal('camera', 'echo'),),"
            "failures=(Failure('F6', 'a', 'b', 'c', signal='camera_echo'),))",
            "The failure F6 needs a threshold of the signal camera_echo, which has none",
        ),
        (HEAD + "EXTENSION = Extension(suites={'mine': ('gpu_failure',)})", "must be tuples of faults"),
        (HEAD + "EXTENSION = Extension(suites={'mine': (('gpu',),)})", "refers to the fault 'gpu'"),
    ],
)
def test_a_wrong_extension_gets_one_sentence(
    source: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "sonar.py"
    file.write_text(source, encoding="utf-8")

    assert main(["faults", "list", "--extension", str(file)]) == 2

    told = capsys.readouterr().err
    assert sentence in told
    assert len(told.splitlines()) == 1
    assert told.endswith(".\n")
    assert loaded_extensions() == ()


def test_a_file_that_is_not_there_and_a_name_that_is_not_installed_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ExtensionError, match=r"There is no extension .*sonar\.py: name a Python file\."):
        load_extension(tmp_path / "sonar.py")
    with pytest.raises(
        ExtensionError, match=r"There is no extension 'sonar': name a Python file, or one that is"
    ):
        load_extension("sonar")


def test_a_verb_without_a_managed_system_takes_no_extension(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as way_out:
        main(["completion", "bash", "--extension", "sonar.py"])
    assert way_out.value.code == 2
    assert "There is no argument '--extension' here" in capsys.readouterr().err


def test_an_option_without_a_file_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as way_out:
        main(["faults", "list", "--extension"])
    assert way_out.value.code == 2
    assert "--extension" in capsys.readouterr().err


def test_an_extension_is_loaded_once_and_gone_after_its_context(tmp_path: Path) -> None:
    file = tmp_path / "sonar.py"
    file.write_text(SONAR + "EXTENSION = Extension(nodes=(NodeDescription('sonar', Sonar, ()),))\n")
    with extended_system([file, file]) as system:
        assert "sonar" in system.nodes
        assert [extension.name for extension in loaded_extensions()] == ["sonar.py"]
        with pytest.raises(ExtensionError, match="has changed since the run was planned"):
            load_extension(file, checksum="0")
    assert "sonar" not in current_system().nodes


def test_an_installed_extension_is_found_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "sonar_package.py").write_text(
        SONAR + "EXTENSION = Extension(nodes=(NodeDescription('sonar', Sonar, ()),))\n"
    )
    about = tmp_path / "sonar_package-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: sonar-package\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[sunset.extensions]\nsonar = sonar_package:EXTENSION\n")
    monkeypatch.syspath_prepend(tmp_path)
    with extended_system(["sonar"]) as system:
        assert "sonar" in system.nodes
        (loaded,) = loaded_extensions()
        assert (loaded.name, loaded.where, len(loaded.checksum)) == ("sonar", "sonar", 64)
