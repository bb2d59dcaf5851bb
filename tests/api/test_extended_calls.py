"""Calls from Python take extensions of the managed system, which are gone when they return."""

import json
import re
from pathlib import Path

import pytest
from tests.docs.test_docs import blocks

import sunset
from sunset.data import read_bag, write_bag
from sunset.errors import ExtensionError, RecordError, SunsetError
from sunset.evaluation.results import load_results
from sunset.system import current_system, extended_system, loaded_extensions

pytestmark = pytest.mark.usefixtures("flight")


class Level(sunset.ManagingSystem):
    def adapt(self, symptoms: sunset.Symptoms) -> None:
        if symptoms.get("altimeter_height", 0.0) > 500:  # type: ignore[operator]
            self.set_parameter("altimeter", "recalibrate", True)


@pytest.fixture
def page(tmp_path: Path) -> Path:
    """The extensions of the page, in a folder."""
    for source in blocks("docs/extending.md", "python"):
        (tmp_path / source.splitlines()[0].removeprefix("# ")).write_text(source, encoding="utf-8")
    return tmp_path


def test_a_run_has_the_faults_of_several_extensions(page: Path) -> None:
    extensions: list[str | Path] = [page / "altimeter.py", str(page / "dirt.py")]

    run = sunset.run(
        "altimeter_drift+lens_dirt", Level, seed=2, duration=4, extensions=extensions, out=page / "run"
    )

    assert loaded_extensions() == ()
    assert [episode.failure for episode in run.episodes if episode.resolved] == ["F6"]
    assert "set altimeter.recalibrate to true" in map(str, run.adaptations)
    assert sunset.load(page / "run", extensions=extensions).digest == run.digest  # type: ignore[union-attr]
    assert re.search(" symptom +F6 ", str(run))
    assert run.view(out=page / "run.html", show=False).stat().st_size > 10_000
    assert "<iframe" in str(run._repr_html_())
    with pytest.raises(RecordError, match="name it with --extension, in Python with extensions"):
        sunset.load(page / "run")
    with pytest.raises(SunsetError, match="There is no scenario 'altimeter_drift'"):
        sunset.run("altimeter_drift", "none")


@pytest.mark.thorough
def test_a_campaign_of_several_processes_has_them_too(page: Path) -> None:
    results = sunset.bench(
        "heights",
        {"level": Level, "none": "none"},
        out=page / "results",
        repetitions=1,
        references=False,
        score=False,
        duration=3,
        jobs=2,
        extensions=page / "altimeter.py",
    )

    assert {run.scenario for run in results.runs} == {
        "heights/altimeter_drift",
        "heights/altimeter_drift=600+autofocus_needed",
    }
    assert results.compare("level", "none").pairs == 2
    again = sunset.report(page / "results", recompute=True, extensions=page / "altimeter.py")
    assert again == results.table()
    assert "altimeter" not in current_system().nodes


def test_a_manager_is_checked_against_an_extension(page: Path) -> None:
    check = sunset.check_manager(Level, "altimeter_drift", duration=3, extensions=page / "altimeter.py")
    assert check.passed


LIGHT_METER = Path(__file__).parents[1] / "experiments" / "lightmeter.py"
FAILED = r"^The node light_meter failed in nofault, seed 2: it "
WHERE = r" \(lightmeter.py, line \d+, in fail\)\.$"


@pytest.mark.parametrize("manager", ["none", Level])
@pytest.mark.parametrize(
    ("mistake", "sentence"),
    [
        ("set_up raises", r"^The node light_meter could not be started: ValueError: mine" + WHERE),
        ("set_up ends its process", FAILED + r"ended its process with exit code 3\.$"),
        ("on_timer raises", FAILED + "raised ValueError: mine" + WHERE),
        ("on_timer exits", FAILED + "raised SystemExit: enough" + WHERE),
        ("on_timer ends its process", FAILED + r"ended its process with exit code 3\.$"),
        ("on_timer loops", FAILED + r"did not return within (1\.5 s of processor time|15 s)" + WHERE),
    ],
)
def test_a_node_of_an_extension_that_fails_is_named(
    manager: str | type[Level], mistake: str, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LIGHT_METER", mistake)
    monkeypatch.setattr("sunset.experiments.manager._STILL_S", 0.0)
    limit_s = 1.5 if mistake.endswith("loops") else 20.0  # a busy computer may take its time

    with pytest.raises(ExtensionError, match=sentence):
        sunset.run("nofault", manager, seed=2, duration=1, manager_limit=limit_s, extensions=LIGHT_METER)


def test_a_campaign_goes_on_when_a_node_of_an_extension_fails(
    page: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LIGHT_METER", "set_up raises")

    results = sunset.bench(
        "nofault",
        {"none": "none", "level": Level},
        out=page / "results",
        repetitions=2,
        references=False,
        score=False,
        duration=1,
        jobs=1,
        extensions=LIGHT_METER,
    )

    reasons = [json.loads(file.read_text())["reason"] for file in page.glob("results/runs/*/*/*/*/run.json")]
    assert len(reasons) == 4
    assert all(reason.startswith("The node light_meter could not be started") for reason in reasons)
    assert "light_meter" in results.table()


@pytest.mark.thorough
def test_curves_have_its_faults_and_so_has_a_list_in_its_context(page: Path, flight: Path) -> None:
    with read_bag(flight) as reader:
        five = write_bag(
            page / "five", [reader.frame(index) for index in range(5)], list(reader.stamps_ns[:5])
        )

    curves = sunset.measure_curves("lite", five, every=1, jobs=1, extensions=page / "dirt.py")

    assert [case.strengths["lens_dirt"] for case in curves.of("lens_dirt")] == [1, 2, 3, 4]
    assert "lens_dirt" not in {fault.name for fault in sunset.list_faults()}
    with extended_system([page / "dirt.py"]):
        assert "lens_dirt" in {fault.name for fault in sunset.list_faults()}
        assert sunset.make_scenario("lens_dirt").name == "lens_dirt"


BLIND = """\
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset.nodes import AdaptiveNode, FaultParameter
from sunset.system import Adaptation, AdaptationKind, Extension, Failure, Fault, NodeDescription, Topic


class Relay(AdaptiveNode):
    node_name = "relay"
    stuck = FaultParameter(False, "whether nothing is passed on")

    def set_up(self):
        self.images = self.create_lifecycle_publisher(Image, "relayed", 10)
        self.create_active_subscription(Image, "rgb_camera", self.pass_on)

    def pass_on(self, message):
        if not self.stuck:
            self.images.publish(message)


REDEPLOY = Adaptation(AdaptationKind.REDEPLOY, "relay")
EXTENSION = Extension(
    nodes=(NodeDescription("relay", Relay, inputs=("rgb_camera",), outputs=("relayed",)),),
    topics=(Topic("relayed"),),
    failures=(Failure("F9", "nothing is relayed", symptom="silence", gone="noise", topic="relayed"),),
    faults=(Fault(name="stuck", failure="F9", node="relay", cures=((REDEPLOY,),), description="It is stuck."),),
    suites={"relays": (("stuck",), ("stuck", "autofocus_needed"), ("stuck", "depth_degradation"))},
)
"""


@pytest.mark.thorough
def test_the_report_of_a_folder_is_the_same_without_the_extension_of_its_runs(tmp_path: Path) -> None:
    extension = tmp_path / "relay.py"
    extension.write_text(BLIND)
    sunset.bench(
        "relays",
        ["none", "baseline"],
        scenarios=["relays/stuck", "relays/stuck+autofocus_needed"],
        out=tmp_path / "runs",
        repetitions=1,
        references=False,
        score=False,
        duration=2,
        extensions=extension,
    )
    for form in ("table", "json", "csv"):
        alone = sunset.report(tmp_path / "runs", form=form)
        assert alone == sunset.report(tmp_path / "runs", form=form, extensions=extension)
    assert "2 of 3 scenarios" in alone
    clusters = {(run.scenario, run.cluster.alike) for run in load_results(tmp_path / "runs")}
    assert clusters == {("relays/stuck", "F9"), ("relays/stuck+autofocus_needed", "autofocus_needed")}
