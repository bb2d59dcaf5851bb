"""Scenarios by name, by faults, from files: and what is said about bad ones."""

from pathlib import Path

import pytest

from sunset.errors import ScenarioError
from sunset.scenarios import Scenario, generate, load_scenario, load_suite, parse_scenario, suite

GOOD = """\
name: mine
description: Two at once.
faults:
  - name: image_shift
    value: 25
  - gpu_failure
"""

PUBLISHED = """\
- is_gt_failure: true
  name: image_shift
  target_node: /managed_subsystem/sensor_fusion
  type: parameter_adaptation
  value: 300
  criticality_level: Warning
- is_gt_failure: true
  name: do_hard_drop_rgb_camera
  target_node: /managed_subsystem/camera
  type: parameter_adaptation
  value: true
  probability: 0.5
  criticality_level: Failure
- is_gt_failure: true
  name: autofocus_needed
  target_node: /managed_subsystem/camera
  type: parameter_adaptation
  value: true
  criticality_level: Ok
"""


def faults(scenario: Scenario) -> list[tuple[str, object]]:
    return [(fault.name, fault.value) for fault in scenario.faults]


def write(folder: Path, text: str) -> Path:
    file = folder / "scenario_007.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_file_of_ours_is_read(tmp_path: Path) -> None:
    scenario = load_scenario(write(tmp_path, GOOD))
    assert (scenario.name, scenario.description) == ("mine", "Two at once.")
    assert faults(scenario) == [("image_shift", 25), ("gpu_failure", True)]


def test_a_folder_of_files_is_a_suite_in_their_order(tmp_path: Path) -> None:
    for file, name in (("b.yaml", "first"), ("c.yml", "last"), ("notes.txt", "none"), ("a.yaml", "zeroth")):
        (tmp_path / file).write_text(GOOD.replace("mine", name), encoding="utf-8")
    assert [one.name for one in load_suite(tmp_path)] == ["zeroth", "first", "last"]
    assert load_suite("paper") == suite("paper")


def test_a_folder_that_is_no_suite_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"There is no suite '.*/none': name paper, .* or a folder"):
        load_suite(tmp_path / "none")
    with pytest.raises(ScenarioError, match="there is no YAML file in this folder"):
        load_suite(tmp_path)
    for file, name in (("a.yaml", "x/mine"), ("b.yaml", "mine")):
        (tmp_path / file).write_text(GOOD.replace("mine", name), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"a\.yaml and .*b\.yaml are both called 'mine': rename one"):
        load_suite(tmp_path)


def test_a_published_file_is_read_with_strengths_scaled_to_our_images(tmp_path: Path) -> None:
    scenario = load_scenario(write(tmp_path, PUBLISHED))
    assert scenario.name == "scenario_007"
    assert faults(scenario) == [
        ("image_shift", 10),
        ("hardware_disconnect", True),
        ("autofocus_needed", True),
    ]


@pytest.mark.parametrize(
    ("published", "node", "ours"),
    [
        ("do_drop_camera", "camera", "camera_driver_issue"),
        ("do_drop_rgb_camera", "camera", "camera_driver_issue"),
        ("do_hard_drop_camera", "camera", "hardware_disconnect"),
        ("do_drop_sensor_fusion", "sensor_fusion", "sync_issue"),
        ("do_hard_drop_sensor_fusion", "sensor_fusion", "memory_leakage"),
        ("do_drop_segmentation", "segmentation", "cuda_out_of_memory"),
        ("do_hard_drop_segmentation", "segmentation", "gpu_failure"),
        ("memory_leakage", "sensor_fusion", "memory_leakage"),
    ],
)
def test_old_and_new_published_names_are_known(tmp_path: Path, published: str, node: str, ours: str) -> None:
    text = f"- {{name: {published}, target_node: /managed_subsystem/{node}, type: parameter_adaptation, value: true}}"
    assert faults(load_scenario(write(tmp_path, text))) == [(ours, True)]


def test_the_published_degradations_become_the_strengths_of_our_suite(tmp_path: Path) -> None:
    text = """\
- {name: image_degradation, target_node: /managed_subsystem/camera, type: parameter_adaptation, value: 1.5}
- {name: depth_degradation, target_node: /managed_subsystem/depth, type: parameter_adaptation, value: 2.}
"""
    ours = generate(["image_degradation", "depth_degradation"])
    assert faults(load_scenario(write(tmp_path, text))) == faults(ours)


def test_faults_joined_by_plus_make_a_scenario() -> None:
    assert faults(load_scenario("gpu_failure+image_shift")) == [("gpu_failure", True), ("image_shift", 10)]
    assert faults(generate(["image_degradation=0.5"], name="dim")) == [("image_degradation", 0.5)]
    assert faults(generate(["image_degradation=5e-1"])) == [("image_degradation", 0.5)]


def test_a_misspelt_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(ScenarioError, match="did you mean 'degraded/image_shift"):
        load_scenario("degraded/image_shift+autofocus_neded")
    with pytest.raises(ScenarioError, match="did you mean 'gpu_failure'"):
        load_scenario("gpu_failur")


@pytest.mark.parametrize("name", ["", "no such thing", "paper/none", "..."])
def test_an_unknown_name_is_answered_with_the_suites(name: str) -> None:
    with pytest.raises(ScenarioError, match="paper, artifact, nofault, degraded"):
        load_scenario(name)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("# only a comment\n", "is empty"),
        ("name: [unclosed", "line 1: this is not valid YAML"),
        ("name: a\nfaults:\n  - name: b\n   value: 2\n", "line 4: this is not valid YAML"),
        ("name: a\n", "the key 'faults' is missing"),
        ("name: a\nfaults: []\ncolour: red\n", "line 3: the key 'colour' is not known here"),
        ("name: a\nname: b\nfaults: []\n", "line 2: the key 'name' is given twice"),
        ("name: 3\nfaults: []\n", "line 1: The name must be a text, got 3"),
        ("name: a\nfaults: gpu_failure\n", "line 2: a list is expected for 'faults'"),
        ("name: a\nfaults:\n- gremlin\n", "line 3: There is no fault 'gremlin'"),
        (
            "name: a\nfaults:\n- name: image_shift\n  value: [1]\n",
            "line 4: a truth value, a number or a text",
        ),
        (
            "name: a\nfaults:\n- name: image_shift\n  value: -4\n",
            "line 3: The value of the fault image_shift",
        ),
        (
            "name: a\nfaults:\n- name: image_shift\n  value: 2026-11-31\n",
            "line 4: '2026-11-31' is not a value",
        ),
        (
            "name: a\nfaults: [gpu_failure, gpu_failure]\n",
            "line 2: The scenario has the fault gpu_failure twice",
        ),
        ("just text", "line 1: a mapping with name, faults is expected here"),
        ("!!python/object/apply:os.system ['true']", "line 1"),
        ("- name: image_shift\n", "line 1: the key 'target_node' is missing"),
        ("[" * 5000, "nested too deeply"),
        ("a: &a [*a]\n? *a\n: 1\n", "line 1"),
        ("name: a\n---\nname: b\n", "line 2: this is not valid YAML: but found another document"),
        ("name: \x01\n", "not valid YAML"),
    ],
)
def test_a_bad_file_is_answered_with_the_file_and_the_line(tmp_path: Path, text: str, said: str) -> None:
    file = write(tmp_path, text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file)
    assert str(caught.value).startswith(str(file))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (
            "{name: image_shift, target_node: /x/camera, type: parameter_adaptation, value: 3}",
            "must have the target",
        ),
        (
            "{name: image_shift, target_node: /x/sensor_fusion, type: message, value: 3}",
            "must be parameter_adaptation",
        ),
        (
            "{name: warp, target_node: /x/sensor_fusion, type: parameter_adaptation, value: 3}",
            "no fault 'warp'",
        ),
        ("{name: image_shift, target_node: a, type: b, value: 3, stamp: 7}", "'stamp' is not known"),
    ],
)
def test_a_bad_published_entry_is_refused(tmp_path: Path, entry: str, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        load_scenario(write(tmp_path, f"- {entry}\n"))


def test_a_folder_and_a_file_are_not_taken_for_each_other(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"is a folder, and so a suite: .* 'sunset bench --suite "):
        load_scenario(str(tmp_path))
    with pytest.raises(ScenarioError, match="is a file, and a suite is a folder of scenario files"):
        load_suite(write(tmp_path, "name: a\nfaults: []\n"))


def test_a_file_that_is_missing_a_folder_or_no_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"There is no scenario file .*missing\.yaml\.$"):
        load_scenario(tmp_path / "missing.yaml")
    folder = tmp_path / "folder.yaml"
    folder.mkdir()
    with pytest.raises(ScenarioError, match="cannot be read: Is a directory"):
        load_scenario(folder)
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"name: \xff\xfe")
    with pytest.raises(ScenarioError, match="not text in UTF-8"):
        load_scenario(binary)
    large = tmp_path / "large.yaml"
    large.write_bytes(b"#" * 1_000_001)
    with pytest.raises(ScenarioError, match="larger than"):
        load_scenario(large)


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("+3", 3), ("3.", 3), ("003.0", 3), (".3e+1", 3), ("3.0e+0", 3), ("30.0e-1", 3)],
)
def test_a_number_that_means_the_same_everywhere_is_read(text: str, value: int) -> None:
    content = f"name: x\nfaults: [{{name: image_shift, value: {text}}}]"
    assert parse_scenario(content, "a.yaml").faults[0].value == value
