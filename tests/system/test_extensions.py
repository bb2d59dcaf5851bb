"""Extensions that are wrong get one sentence; what was loaded for a while is gone after it."""

import hashlib
import os
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.errors import ExtensionError, ScenarioError
from sunset.scenarios import load_suite
from sunset.system import System, current_system, extended_system, load_extension, loaded_extensions

BLUR = "import cv2\nblur = lambda image, strength: cv2.blur(image, (3, 3))\n"


def fault(effect: str, *, failure: str = "F4", value: str = "value=2, limits=(0, 9)") -> str:
    """Return an extension with one fault, which has an effect."""
    return (
        f"{HEAD}{BLUR}EXTENSION = Extension(faults=(Fault(name='smear', failure={failure!r}, node='camera', {value}, "
        f"description='Smeared.', cures=((Adaptation('redeploy', 'camera'),),), effect=Effect({effect})),))"
    )


HEAD = "from sunset.nodes import AdaptiveNode\nfrom sunset.system import *\n"
REDEPLOY = "REDEPLOY = Adaptation(AdaptationKind.REDEPLOY, 'camera')\n"
SONAR = HEAD + "class Sonar(AdaptiveNode):\n    node_name = 'sonar'\n"


DIRTY = (
    f"{HEAD}from sunset.nodes import Camera, FaultParameter\n"
    "class Dirty(Camera):\n    smear = FaultParameter(False, 'dirt', {})\n"
)
"""A class of a node with a parameter of a fault, which gets options."""
DIRT = (
    "EXTENSION = Extension(node_classes={'camera': Dirty}, faults=(Fault(name='smear', failure='F1', node='camera', "
    "description='Smeared.', cures=((Adaptation('redeploy', 'camera'),),)),))"
)


def node(name: str, options: str = "compute_s=0.0") -> str:
    """Return the rest of an extension with one node."""
    described = f"NodeDescription({name!r}, Sonar, (), **dict({options}))"
    return f"Sonar.node_name = {name!r}\nEXTENSION = Extension(nodes=({described},))"


def view(value: str, sensor: str) -> str:
    """Return an extension with one view, with the images of one node."""
    setting = f"Adaptation('set_parameter', 'sensor_fusion', 'modality', {value})"
    return f"{HEAD}EXTENSION = Extension(views=(View({setting}, ({sensor!r},)),))"


def of_fault(options: str) -> str:
    """Return an extension with one fault of the camera."""
    return (
        f"{HEAD}{REDEPLOY}EXTENSION = Extension(faults=(Fault(name='smear', failure='F1', node='camera', "
        f"description='Smeared.', {options}),))"
    )


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (
            "import sonar_of_nobody",
            "cannot be imported: it raised ModuleNotFoundError: No module named 'sonar_of",
        ),
        (
            "x = (",
            "sonar.py cannot be imported: it raised SyntaxError: '(' was never closed (sonar.py, line 1).\n",
        ),
        ("raise SystemExit", "cannot be imported: it raised SystemExit (sonar.py, line 1, in <module>).\n"),
        (
            "class Own(BaseException): pass\nraise Own('no')",
            "cannot be imported: it raised Own: no (sonar.py, line 2, in <module>).\n",
        ),
        ("import json\njson.loads('{')", "(char 1) (sonar.py, line 2, in <module>).\n"),
        ("x = 1", "sonar.py has no EXTENSION: assign it an Extension.\n"),
        (HEAD + "EXTENTION = Extension()", "sonar.py has no EXTENSION: rename EXTENTION.\n"),
        ("EXTENSION = None", "must have an Extension as EXTENSION, got NoneType"),
        (
            HEAD + "EXTENSION = Extension(nodes='sonar')",
            "The nodes of an extension must be a tuple of NodeDescr",
        ),
        (
            HEAD + "EXTENSION = Extension(nodes=(NodeDescription('sonar', None, ()),))",
            "The class of the node sonar must have its node_name, got None",
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
            (
                "No node publishes on the topic /managed_subsystem/echo: did you mean "
                "'/managed_subsystem/segmentation', or add /managed_subsystem/echo to the outputs of a node."
            ),
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
            HEAD
            + "EXTENSION = Extension(views=(View(Adaptation('set_parameter', 'camera', 'perform_autofocus', True), "
            "frozenset({'camera'})),))",
            "All views must be values of one parameter, got sensor_fusion.modality and camera.perform_autofocus.",
        ),
        (
            HEAD
            + "EXTENSION = Extension(views=(View(Adaptation('set_parameter', 'sensor_fusion', 'modality', 3), "
            "frozenset({'lidar'})),))",
            "The view 'set sensor_fusion.modality to 3' refers to the sensor 'lidar', which is not there",
        ),
        (
            HEAD
            + "EXTENSION = Extension(views=(View(Adaptation('set_parameter', 'sensor_fusion', 'modality', 1), "
            "frozenset({'camera'})),))",
            "Each view must have a value of its own, got 0, 1, 2, 1.",
        ),
        (
            HEAD + "EXTENSION = Extension(views=(View(0, frozenset({'camera'})),))",
            "The View '0' is not usable: The setting must be an Adaptation, got 0 (",
        ),
        *(
            (
                f"{HEAD}EXTENSION = Extension(views=(View(Adaptation('redeploy', 'camera'), {sensors}),))",
                f"The sensors must be a set of names of nodes, such as frozenset({{'camera'}}), got {sensors} (",
            )
            for sensors in ("'camera'", "frozenset()")
        ),
        (
            view("3", "segmentation"),
            "refers to the sensor 'segmentation', which is not there: name one of camera, depth.",
        ),
        (view("'rgb'", "camera"), "the parameter 'modality' of type int, got 'rgb'"),
        (view("float('nan')", "camera"), "the parameter 'modality' of type int, got nan"),
        (view("3", "camera"), "takes for the parameter 'modality' values from 0 to 2, got 3"),
        *(
            (
                f"{HEAD}EXTENSION = Extension(prices={{'restart': {price}}})",
                f"The restart in the prices of an extension must be a number from 0 to 100000, got {got}; change it",
            )
            for price, got in {
                "'1'": "'1'",
                "None": "None",
                "float('nan')": "nan",
                "float('inf')": "inf",
                "-1": "-1",
            }.items()
        ),
        (
            HEAD + "EXTENSION = Extension(prices={'reboot': 1})",
            "The reboot in the prices of an extension must be one of restart, redeploy, set_parameter, change_topic, ",
        ),
        (
            HEAD + "EXTENSION = Extension(signals=(Signal('camera', 'echo'),),"
            "failures=(Failure('F6', 'a', 'b', 'c', signal='camera_echo'),))",
            "The failure F6 needs a threshold of the signal camera_echo.",
        ),
        (
            HEAD + "EXTENSION = Extension(signals=(Signal('camera', 'echo', calibrated=True),))",
            "The signal camera_echo needs a threshold of its own: model cards lack it.",
        ),
        (
            HEAD
            + "EXTENSION = Extension(faults=(Fault(name='asleep', failure='F2', node='depth', description='', "
            "cures=(), injection=(Adaptation(AdaptationKind.DEACTIVATE, 'depth'),)),))",
            "The fault asleep cannot be injected by 'deactivate depth': set a parameter, or activate a node",
        ),
        (
            fault("degrade=blur, strengths=(1,)", failure="F1"),
            "only if its failure is of a signal whose thres",
        ),
        (
            fault("degrade=blur, strengths=(1,), sensor='ear'"),
            "The sensor must be 'camera' or 'depth', got 'ear'",
        ),
        (
            fault("degrade='blur', strengths=(1,)"),
            "The function blur of a fault's effect cannot be imported: No module named 'blur'",
        ),
        (
            fault("degrade='cv2:smear', strengths=(1,)"),
            "The function cv2:smear of a fault's effect cannot be im",
        ),
        (fault("degrade=blur, strengths=(1, 10)"), "needs strengths greater than 0 and at most 9, got 10"),
        (fault("degrade=blur, strengths=('1',)"), "The strengths must be a list, got ('1',)"),
        (
            fault("degrade=blur, strengths=(1,), suite=1.0"),
            "fault's value is not a number, and only then, got 1.0",
        ),
        (
            fault("degrade=blur, strengths=(1,)", value="value=True"),
            "is not a number, and only then, got None",
        ),
        (
            HEAD + "EXTENSION = Extension(suites={'mine': ('gpu_failure',)})",
            "The mine in the suites of an extension must be tuples of faults or a YAML text, got ('gpu_failure',)",
        ),
        (HEAD + "EXTENSION = Extension(suites={'mine': ''})", "The suite mine has no scenario"),
        (SONAR + node("monitor"), "The node name 'monitor' is the experiment's own"),
        (SONAR + node("managing_system"), "The node name 'managing_system' is the experiment's own"),
        (
            SONAR + node("sonar", "activation_delay_s=-5.0"),
            "The activation_delay_s must be a number from 0 to 3600 s, or -1, got -5.0",
        ),
        (
            SONAR + node("sonar", "activation_delay_s='5'"),
            "The activation_delay_s must be a number from 0 to 3600 s, or -1, got '5'",
        ),
        (
            SONAR + node("sonar", "outputs='echo'"),
            "The outputs must be a tuple of topics' names, such as ('rgb_camera',), got 'echo'",
        ),
        (of_fault("cures=(REDEPLOY,)"), "must be a tuple of tuples of adaptations, such as ((RESTART,), "),
        (of_fault("cures=((),)"), "must be a tuple of tuples of adaptations, such as ((RESTART,), "),
        (
            of_fault("cures=((REDEPLOY,),), kind='extern'"),
            "The kind must be internal, external or configuration, got 'extern'",
        ),
        (
            of_fault("cures=((Adaptation('restrat', 'camera'),),)"),
            "The kind must be one of restart, redeploy, set_parameter, change_topic, activate, deactivate, got 'restr",
        ),
        (
            HEAD + "EXTENSION = Extension(exclusive=(('gpu_failure', 'image_shift', 'sync_issue'),))",
            "Exclusive faults come in pairs of two names",
        ),
        (
            HEAD + "EXTENSION = Extension(failures=(Failure('F6', 'a', 'b', 'c', topic='/rgb_raw'),))",
            "The failure F6 is of the topic /rgb_raw: add it to the topics that are watched, and to the outputs",
        ),
        (
            HEAD + "EXTENSION = Extension(failures=(Failure('F6', 'a', 'b', 'c', topic='rgb_enhanced'),))",
            "to the outputs of a node that is active at first",
        ),
        (
            of_fault("cures=((REDEPLOY,),), parameter='perform_autofokus'"),
            "does not have the parameter 'perform_autofokus': did you mean 'perform_autofocus'",
        ),
        (
            of_fault("cures=((REDEPLOY,),)"),
            "'smear': add it there, or name another (a fault's parameter has the fault's name unless it says parameter",
        ),
        (
            of_fault("cures=((REDEPLOY,),), parameter='image_degradation', value=1, limits=(0, 1)"),
            "The class Camera has the parameter 'image_degradation' of type float, got 1: write a value such as 0.0",
        ),
        (
            of_fault("cures=((REDEPLOY,),), parameter='image_degradation', value=0.5, limits=(0.0, 99.0)"),
            "The class Camera takes for the parameter 'image_degradation' values from 0.0 to 1.9, got 99.0: change",
        ),
        (
            of_fault(
                "cures=((REDEPLOY,),), parameter='sharpness_threshold', value=9.0, limits=(1.0, 10.0), healthy=1.0"
            ),
            "The fault smear is healthy at 1.0, and the parameter 'sharpness_threshold' of the class Camera begins",
        ),
        (
            HEAD + "class Eye(AdaptiveNode):\n    node_name = 'camera'\n"
            "EXTENSION = Extension(node_classes={'camera': Eye})",
            "The class of the node camera is Camera: Eye must be a subclass of it",
        ),
        (
            SONAR + node("sonar", "outputs=('a b',)"),
            "The outputs must be a tuple of topics' names, such as ('rgb_camera',), got ('a b',)",
        ),
        (SONAR + node("sonar", "outputs=('/rosout',)"), "The name of the topic '/rosout' is taken"),
        (
            SONAR + node("sonar", "outputs=('/parameter_events',)"),
            "The name of the topic '/parameter_events' is taken",
        ),
        (
            of_fault("cures=(), parameter='hardware_disconnect'"),
            "The fault smear is internal to camera, so that a redeploy of it ends it: add that to the cures",
        ),
        (
            DIRTY.format("cured_by_restart=True") + DIRT,
            "A restart of camera is not a cure of the fault smear: say cured_by_restart=False for the parameter",
        ),
        (
            of_fault("cures=((REDEPLOY,),), value=0.0, limits=(0.0, 1.0)"),
            "needs a value and another value of the same type when healthy, got 0.0 and 0.0",
        ),
        (of_fault("cures=((REDEPLOY,),), value=[1]"), "The value must be true or false or a whole number"),
        (
            of_fault("cures=((REDEPLOY,),), value=2.0"),
            "The fault smear needs limits if its value is a number, and only then, got 2.0 and None",
        ),
        (
            of_fault("cures=((REDEPLOY,),), value=True, limits=(0.0, 1.0)"),
            "The fault smear needs limits if its value is a number, and only then, got True and (0.0, 1.0)",
        ),
        (
            of_fault("cures=((REDEPLOY,),), value=9.0, limits=(0.0, 5.0)"),
            "The fault smear needs a value within its limits (0.0, 5.0), got 9.0",
        ),
        (
            HEAD + "EXTENSION = Extension(suites={'mine': ({'gpu_failure', 'image_shift'},)})",
            "The suite mine must be tuples of faults: a set does not have an order",
        ),
        (
            HEAD + "EXTENSION = Extension(suites=[])",
            "The suites of an extension must be an object, got []",
        ),
    ],
)
def test_a_wrong_extension_gets_one_sentence(
    source: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "sonar.py"
    file.write_text(source, encoding="utf-8")

    assert main(["faults", "list", "--extension", str(file)]) == 2

    printed = capsys.readouterr().err
    assert sentence in printed
    assert len(printed.splitlines()) == 1
    assert printed.endswith(".\n")
    assert loaded_extensions() == ()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("- {name: a, faults: []}\n- {name: a, faults: []}", "line 2: The scenario a is there twice"),
        ("- name: a\n  faults:\n    - {name: gpu}", "line 3: There is no fault 'gpu'"),
        ("- name: [", "line 1: this is not valid YAML"),
        ("faults: []", "line 1: a list is expected here"),
        ("- faults: []", "line 1: the key 'name' is missing"),
        ("- {name: a}", "line 1: the key 'faults' is missing"),
        (
            "- {name: a, faults: [{name: gpu_failure, at: 30}]}",
            "line 1: The fault gpu_failure comes at 30 s, and",
        ),
    ],
)
def test_a_wrong_scenario_in_the_text_of_a_suite_is_refused_with_its_line(
    text: str, sentence: str, tmp_path: Path
) -> None:
    (file := tmp_path / "mine.py").write_text(f"{HEAD}EXTENSION = Extension(suites={{'mine': {text!r}}})\n")
    with extended_system([file]), pytest.raises(ScenarioError, match=f"^The suite mine, {sentence}"):
        load_suite("mine")


@pytest.mark.parametrize(
    ("faults", "sentence"),
    [
        (
            (("gpu_failure",), ("gpu_failure",)),
            "has the scenario mine/gpu_failure twice; name each once",
        ),
        (
            (("image_shift=5000",),),
            "is not usable: The value of the fault image_shift must be a whole number",
        ),
        ((("image_shift=far",),), "is not usable: The value of the fault image_shift must be a whole number"),
        (
            (("image_degradation", "unneeded_enhancement"),),
            "is not usable: The scenario has both image_degradation and unneeded_enhancement at a time",
        ),
    ],
)
def test_a_wrong_scenario_of_a_suite_is_refused(
    faults: tuple[tuple[str, ...], ...], sentence: str, tmp_path: Path
) -> None:
    (file := tmp_path / "mine.py").write_text(f"{HEAD}EXTENSION = Extension(suites={{'mine': {faults!r}}})\n")
    with extended_system([file]), pytest.raises(ScenarioError, match=f"^The suite mine {sentence}"):
        load_suite("mine")


def test_a_suite_with_an_unknown_fault_is_refused_when_it_is_loaded(tmp_path: Path) -> None:
    (file := tmp_path / "mine.py").write_text(
        f"{HEAD}EXTENSION = Extension(suites={{'mine': (('gpu_failur',),)}})\n"
    )
    with pytest.raises(
        ExtensionError, match="The suite mine refers to the fault 'gpu_failur', which is not there"
    ):
        load_extension(file)


def test_a_file_that_is_not_there_and_a_name_that_is_not_installed_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ExtensionError, match=r"There is no extension .*sonar\.py: name a Python file\."):
        load_extension(tmp_path / "sonar.py")
    with pytest.raises(ExtensionError, match=r"There is no extension 'sonar': name a Python file, or an"):
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


def threads_system() -> System:
    """Return the system of a thread that starts now."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(current_system).result()


def test_an_extension_is_of_the_thread_that_has_loaded_it(tmp_path: Path) -> None:
    file = tmp_path / "sonar.py"
    file.write_text(SONAR + "EXTENSION = Extension(nodes=(NodeDescription('sonar', Sonar, ()),))\n")
    entered, left = threading.Event(), threading.Event()

    def last() -> tuple[bool, bool]:
        with extended_system([]) as system:
            entered.set()
            left.wait()
            return "sonar" in system.nodes, "sonar" in current_system().nodes

    with ThreadPoolExecutor(1) as pool:
        with extended_system([file]):
            other = pool.submit(last)
            entered.wait()
            assert "sonar" in current_system().nodes
            assert "sonar" not in threads_system().nodes
        left.set()
        assert other.result() == (False, False)
    assert "sonar" not in current_system().nodes


def test_the_order_in_which_extensions_are_named_has_no_influence(tmp_path: Path) -> None:
    adds = {
        "sonar": "nodes=(NodeDescription('sonar', Sonar, ()),)",
        "alarm": "nodes=(NodeDescription('alarm', Sonar, ()),)",
    }
    for name, added in adds.items():
        source = SONAR.replace("'sonar'", f"'{name}'").replace('"sonar"', f'"{name}"')
        (tmp_path / f"{name}.py").write_text(f"{source}EXTENSION = Extension({added})\n")
    (tmp_path / "first.py").write_text(
        f"{HEAD}from sunset.nodes import Camera\nclass First(Camera): pass\n"
        "EXTENSION = Extension(node_classes={'camera': First})\n"
    )
    (tmp_path / "again.py").write_text(
        f"{HEAD}from sunset.system import current_system\nclass Again(current_system().node_class('camera')): pass\n"
        "EXTENSION = Extension(node_classes={'camera': Again})\n"
    )
    for order in (("sonar", "alarm"), ("alarm", "sonar")):
        with extended_system([tmp_path / f"{name}.py" for name in order]) as system:
            assert list(system.nodes)[-2:] == ["alarm", "sonar"]
    with extended_system([tmp_path / "first.py", tmp_path / "again.py"]) as system:
        assert system.node_class("camera").__name__ == "Again"


def test_a_second_class_of_a_node_must_be_a_subclass_of_the_first(tmp_path: Path) -> None:
    for name in ("One", "Other"):
        (tmp_path / f"{name}.py").write_text(
            f"{HEAD}from sunset.nodes import Camera\nclass {name}(Camera): pass\n"
            f"EXTENSION = Extension(node_classes={{'camera': {name}}})\n"
        )
    with (
        pytest.raises(ExtensionError, match=r"camera is One: Other must be a subclass of it, or be left"),
        extended_system([tmp_path / "One.py", tmp_path / "Other.py"]),
    ):
        pass
    assert loaded_extensions() == ()


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


def test_an_interrupt_while_an_extension_is_imported_is_one(tmp_path: Path) -> None:
    (file := tmp_path / "slow.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    with pytest.raises(KeyboardInterrupt):
        load_extension(file)


def test_what_an_extension_prints_goes_to_stderr(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (file := tmp_path / "loud.py").write_text(f"{HEAD}print('here')\nEXTENSION = Extension()\n")
    with extended_system([file]):
        pass
    assert capsys.readouterr() == ("", "here\n")


def test_what_runs_of_an_extension_is_what_its_checksum_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.dont_write_bytecode", False)
    for suite in ("mild", "wild"):
        (file := tmp_path / "mine.py").write_text(
            f"{HEAD}EXTENSION = Extension(suites={{'{suite}': (('gpu_failure',),)}})\n"
        )
        os.utime(file, (1, 1))  # the time and size of the other
        with extended_system([file]) as system:
            assert suite in system.suites
            assert loaded_extensions()[0].checksum == hashlib.sha256(file.read_bytes()).hexdigest()
    assert not [*tmp_path.rglob("__pycache__")]


def test_an_extension_that_changes_its_file_has_the_checksum_of_what_ran(tmp_path: Path) -> None:
    text = f"{HEAD}EXTENSION = Extension()\nfrom pathlib import Path\nPath(__file__).write_text('')\n"
    (file := tmp_path / "mine.py").write_text(text)
    with extended_system([file]):
        assert loaded_extensions()[0].checksum == hashlib.sha256(text.encode()).hexdigest()


def test_an_extension_that_was_edited_after_it_was_loaded_is_refused(tmp_path: Path) -> None:
    (file := tmp_path / "mine.py").write_text(f"{HEAD}EXTENSION = Extension()\n")
    with extended_system([file, file]):
        planned = loaded_extensions()[0].checksum
        file.write_text(f"{HEAD}EXTENSION = Extension(suites={{}})\n")
        with pytest.raises(
            ExtensionError, match=r"mine\.py was edited after it was loaded: load it in a new process"
        ):
            load_extension(file)
        load_extension(file, checksum=planned)  # that of what is loaded
