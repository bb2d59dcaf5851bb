"""The ROS 2 packages start what there is, and build the definitions that there are."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import pytest
import yaml

from sunset.nodes import Camera, SegmentationNode
from sunset.nodes.parameters import bound_parameters
from sunset.perception import load_model
from sunset.system import HARNESS, current_system, short_name
from sunset_ros.interfaces import field_types, get_message, get_service

ROOT = Path(__file__).parents[2]
PACKAGES = ROOT / "ros2"
INTERFACES = ROOT / "src" / "sunset"
LAUNCH_FILES = sorted(PACKAGES.glob("*/launch/*.launch.py"))
NAMES = ("experiment_setup", "managed_subsystem", "system_interfaces")
MANAGED = ("camera", "depth", "image_enhancement", "segmentation", "sensor_fusion")


class Started(NamedTuple):
    """A node that a launch file starts."""

    package: str
    executable: str


def cmake(package: str) -> str:
    return (PACKAGES / package / "CMakeLists.txt").read_text("utf-8")


def executables(package: str) -> set[str]:
    """Return the names of the programs that a package installs."""
    (listed,) = re.findall(r"foreach\(node ([\w ]+)\)", cmake(package))
    return set(listed.split())


def started(path: Path) -> list[Started]:
    """Return the nodes that a launch file starts itself."""
    calls = [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.Call)]
    nodes = [call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "Node"]
    keywords = [{word.arg: word.value for word in node.keywords} for node in nodes]
    return [
        Started(ast.literal_eval(words["package"]), ast.literal_eval(words["executable"]))
        for words in keywords
    ]


def depends(package: str) -> dict[str, set[str]]:
    """Return what a package.xml depends on, by tag."""
    root = ET.parse(PACKAGES / package / "package.xml").getroot()  # noqa: S314  our own file
    found: dict[str, set[str]] = {}
    for element in root:
        if element.tag.endswith("depend"):
            found.setdefault(element.tag, set()).add(element.text or "")
    return found


@pytest.mark.parametrize("name", NAMES)
def test_a_package_says_who_it_is(name: str) -> None:
    root = ET.parse(PACKAGES / name / "package.xml").getroot()  # noqa: S314  our own file

    assert root.attrib == {"format": "3"}
    assert root.findtext("name") == name
    assert re.fullmatch(r"\d+\.\d+\.\d+", root.findtext("version") or "")
    assert all(root.findtext(tag) for tag in ("description", "maintainer", "license"))
    assert root.find("maintainer[@email]") is not None
    assert root.findtext("export/build_type") == "ament_cmake"
    assert f"project({name}" in cmake(name)
    assert cmake(name).rstrip().endswith("ament_package()")
    required = set(re.findall(r"find_package\((\w+) REQUIRED\)", cmake(name)))
    declared = depends(name)
    assert required == declared["buildtool_depend"] | declared.get("depend", set())


def test_the_interface_package_builds_the_definitions_of_the_python_package() -> None:
    folder = PACKAGES / "system_interfaces"
    definitions = INTERFACES / "system_interfaces"
    (relative,) = re.findall(
        r'\(definitions "\$\{package\}/([^"$]+)\$\{PROJECT_NAME\}" ABSOLUTE\)', cmake(folder.name)
    )
    patterns = re.findall(r'"\$\{definitions\}/([a-z]+/\*\.[a-z]+)"', cmake(folder.name))

    assert Path(os.path.normpath(folder / relative)) == INTERFACES
    built = {path for pattern in patterns for path in definitions.glob(pattern)}
    assert built == {*definitions.rglob("*.msg"), *definitions.rglob("*.srv")}
    assert [path for path in PACKAGES.rglob("*") if path.suffix in {".msg", ".srv", ".idl"}] == []


def test_the_interface_package_depends_on_the_packages_of_its_fields() -> None:
    kinds = []
    for path in (INTERFACES / "system_interfaces").rglob("*.[ms][sr][gv]"):
        name = f"system_interfaces/{path.suffix[1:]}/{path.stem}"
        if path.suffix == ".msg":
            kinds.append(get_message(name))
        else:
            service = get_service(name)
            kinds += [service.Request, service.Response]
    fields = [field for kind in kinds for field in field_types(kind).values() if field.is_message]
    used = {field.base.split("/")[0] for field in fields} - {"system_interfaces"}

    (listed,) = re.findall(r"DEPENDENCIES ([\w ]+)", cmake("system_interfaces"))
    assert set(listed.split()) == used == depends("system_interfaces")["depend"]


@pytest.mark.parametrize("package", ["experiment_setup", "managed_subsystem"])
def test_every_program_is_a_node_that_the_command_line_has(package: str) -> None:
    program = PACKAGES / package / "node.in"

    assert os.access(program, os.X_OK)
    assert program.read_text("utf-8").splitlines()[-1] == 'exec sunset node @node@ "$@"'
    assert executables(package) <= {*current_system().nodes, *HARNESS}


def test_all_managed_nodes_have_a_launch_file_of_their_name() -> None:
    folder = PACKAGES / "managed_subsystem" / "launch"

    assert executables("managed_subsystem") == set(MANAGED)
    for node in MANAGED:
        text = (folder / f"{node}.launch.py").read_text("utf-8")
        assert f'node = {{"node": "{node}"}}' in text
        assert '"node.launch.py"' in text


def test_a_managed_node_is_started_with_parameters_that_it_has() -> None:
    text = (PACKAGES / "managed_subsystem" / "launch" / "node.launch.py").read_text("utf-8")
    declared = set(re.findall(r'DeclareLaunchArgument\(\s*"(\w+)"', text))

    assert declared == {"node", "use_sim_time", "autostart", "params_file"}
    assert "autostart" in bound_parameters(Camera)


def test_the_parameter_file_has_the_nodes_own_values() -> None:
    file = PACKAGES / "managed_subsystem" / "config" / "parameters.yaml"
    for name, content in yaml.safe_load(file.read_text("utf-8")).items():
        bound = bound_parameters(current_system().node_class(short_name(name)))
        values = content["ros__parameters"]
        assert values == {parameter: bound[parameter].default for parameter in values}


def test_the_whole_system_is_every_managed_node() -> None:
    tree = ast.parse((PACKAGES / "managed_subsystem" / "launch" / "full_system.launch.py").read_text("utf-8"))
    (listed,) = [node.value for node in tree.body if isinstance(node, ast.Assign)]

    assert sorted(ast.literal_eval(listed)) == sorted(MANAGED)


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_a_launch_file_starts_programs_that_are_installed(path: Path) -> None:
    for package, executable in started(path):
        assert executable in executables(package)
    others = {package for package, _ in started(path)} - {path.parts[-3]}
    included = set(re.findall(r'FindPackageShare\("(\w+)"\)', path.read_text("utf-8"))) - {path.parts[-3]}
    assert others | included <= depends(path.parts[-3])["exec_depend"]


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_a_launch_file_uses_what_launch_has_and_what_it_imports(path: Path) -> None:
    tree = ast.parse(path.read_text("utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    names = {alias.name for each in imports for alias in each.names}
    called = {
        node.func.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }

    assert functions == ["generate_launch_description"]
    assert {(each.module or "").split(".")[0] for each in imports} <= {"launch", "launch_ros"}
    assert called <= names


def test_the_experiment_passes_parameters_that_its_nodes_have() -> None:
    path = PACKAGES / "experiment_setup" / "launch" / "experiment.launch.py"
    text = path.read_text("utf-8")
    declared = set(re.findall(r'DeclareLaunchArgument\("(\w+)"', text))

    for_viewers = {"image_views"}  # which users start
    assert {name for _, name in started(path)} == executables("experiment_setup") - for_viewers
    assert set(re.findall(r'LaunchConfiguration\("(\w+)"\)', text)) == declared
    for parameter in re.findall(r'"(\w+)": ParameterValue', text):
        sources = [
            *(ROOT / "src/sunset/harness").glob("*bag_player.py"),
            ROOT / "src/sunset/harness/executor.py",
        ]
        assert any(f'"{parameter}"' in source.read_text("utf-8") for source in sources), parameter
    assert set(re.findall(r'SetParameter\("(\w+)"', text)) <= set(bound_parameters(Camera))


def test_the_experiment_plays_the_flight_in_the_size_that_its_model_needs() -> None:
    text = (PACKAGES / "experiment_setup" / "launch" / "experiment.launch.py").read_text("utf-8")
    defaults = dict(re.findall(r'DeclareLaunchArgument\("(\w+)", default_value="([\d.]+)"', text))
    card = load_model(SegmentationNode.model.default).card

    assert (int(defaults["width"]), int(defaults["height"])) == (card.width, card.height)


def test_a_program_takes_the_arguments_that_launch_gives() -> None:
    words = ["--ros-args", "-r", "__node:=camera", "-p", "lifecycle_activation_delay:=text"]
    done = subprocess.run(
        [sys.executable, "-m", "sunset", "node", "camera", *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )

    assert done.returncode == 2
    assert "lifecycle_activation_delay" in done.stderr
