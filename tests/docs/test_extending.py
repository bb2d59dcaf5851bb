"""The extensions of the page are run, seen, cured, scored and computed again, in the simulation and live."""

import json
from pathlib import Path

import pytest
from tests.docs.test_docs import blocks
from tests.live.systems import eventually, exists, going_up

from sunset.cli import main
from sunset.system import current_system, extended_system
from sunset.system_interfaces.srv import Redeploy
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters, SetParameters
from sunset_ros.parameter import Parameter

SHORT = ("--duration", "5")


@pytest.fixture
def page(flight: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write the files of the page into the working directory."""
    del flight
    monkeypatch.chdir(tmp_path)
    for source in blocks("docs/extending.md", "python"):
        name = source.splitlines()[0].removeprefix("# ")
        assert len(source.splitlines()) <= 80, name
        Path(name).write_text(source, encoding="utf-8")


def run_summary(*words: str, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["run", *words, "--json"]) == 0
    summary: dict[str, object] = json.loads(capsys.readouterr().out)
    return summary


@pytest.mark.usefixtures("page")
def test_its_fault_is_injected_seen_cured_and_scored(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--extension", "altimeter.py", *SHORT, "--out", "drift")
    summary = run_summary(
        "heights/altimeter_drift", "--manager", "levelling.py:Levelling", *words, capsys=capsys
    )
    metrics = summary["metrics"]
    assert isinstance(metrics, dict)
    assert summary["valid"]
    assert (metrics["episodes"], metrics["episodes_resolved"], metrics["redeploys_unnecessary"]) == (1, 1, 0)

    assert main(["report", "drift", "--extension", "altimeter.py"]) == 0
    told = capsys.readouterr().out
    assert "altimeter_drift: The altimeter shows more than the height." in told
    assert "F6 height over 500 m" in told
    assert "F6 the height is plausible again" in told
    assert "set altimeter.recalibrate to true" in told
    assert "no symptom is left" in told
    assert "computed here" not in told
    assert not current_system().failures.keys() & {"F6"}


@pytest.mark.usefixtures("page")
def test_its_suite_in_time_is_listed_run_and_known_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--extension", "storms.py")
    assert main(["scenarios", "list", "--suite", "storms", *words]) == 0
    assert capsys.readouterr().out == "storms/lightning\nstorms/fog\n"
    assert main(["scenarios", "show", "storms/fog", *words]) == 0
    assert "duration: 40.0" in capsys.readouterr().out
    bench = (
        "bench",
        "--suite",
        "storms",
        "--scenarios",
        "lightning",
        "--managers",
        "none",
        "--repetitions",
        "1",
    )
    assert (
        main(
            [*bench, "--no-references", "--no-score", "--duration", "3", "--out", "storms", *words, "--json"]
        )
        == 0
    )
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert "[1 of 2 scenarios]" in row["system"]
    assert row["runs"] == 1


@pytest.mark.usefixtures("page")
def test_its_node_in_line_is_upstream_and_hands_images_on(capsys: pytest.CaptureFixture[str]) -> None:
    with extended_system(["relay.py"]):
        assert "relay" in current_system().upstream["sensor_fusion"]

    words = ("--extension", "relay.py", "--duration", "2", "--out", "relayed")
    summary = run_summary("nofault", "--manager", "none", *words, capsys=capsys)
    metrics = summary["metrics"]
    assert isinstance(metrics, dict)
    assert summary["valid"]
    assert (metrics["episodes"], metrics["availability"]) == (0, 1.0)


@pytest.mark.usefixtures("page")
def test_without_a_cure_its_failure_stays(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--extension", "altimeter.py", *SHORT, "--out", "drift")
    summary = run_summary("altimeter_drift=600", "--manager", "none", *words, capsys=capsys)
    metrics = summary["metrics"]
    assert isinstance(metrics, dict)
    assert (metrics["episodes"], metrics["episodes_unresolved"]) == (1, 1)


@pytest.mark.usefixtures("page")
def test_a_record_names_the_extensions_that_it_needs(capsys: pytest.CaptureFixture[str]) -> None:
    run_summary("nofault", "--extension", "altimeter.py", *SHORT, "--out", "with", capsys=capsys)
    run_summary("nofault", *SHORT, "--out", "without", capsys=capsys)

    assert main(["report", "with"]) == 2
    assert "was made with the extension altimeter.py: name it with --extension" in capsys.readouterr().err
    assert main(["report", "without", "--extension", "altimeter.py"]) == 2
    assert "was made without the extension altimeter.py: leave it out" in capsys.readouterr().err
    Path("altimeter.py").write_text(Path("altimeter.py").read_text() + "\n# changed\n")
    assert main(["report", "with", "--extension", "altimeter.py"]) == 2
    assert "was made with another version of the extension altimeter.py" in capsys.readouterr().err


@pytest.mark.usefixtures("page")
def test_its_fault_and_suite_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["faults", "list", "--extension", "altimeter.py"]) == 0
    assert "F6: the drone flies higher than it can" in capsys.readouterr().out
    assert main(["scenarios", "list", "--extension=altimeter.py", "--suite", "heights"]) == 0
    listed = capsys.readouterr().out
    assert "heights/altimeter_drift=600+autofocus_needed" in listed
    assert main(["faults", "list"]) == 0
    assert "altimeter" not in capsys.readouterr().out


@pytest.mark.usefixtures("page")
def test_a_fault_of_a_node_that_is_there_shows_and_is_cured(capsys: pytest.CaptureFixture[str]) -> None:
    Path("cleaning.py").write_text(
        "from sunset.managing import ManagingSystem\n\n\n"
        "class Cleaning(ManagingSystem):\n"
        "    def adapt(self, symptoms):\n"
        "        if symptoms.autofocus_needed:\n"
        "            self.restart('camera')\n",
        encoding="utf-8",
    )
    words = ("--extension", "dirt.py", *SHORT, "--out", "drift")
    run_summary("lens_dirt", "--manager", "cleaning.py:Cleaning", *words, capsys=capsys)

    assert main(["report", "drift", "--extension", "dirt.py"]) == 0
    told = capsys.readouterr().out
    assert "lens_dirt: The camera's lens is dirty." in told
    assert "F5 camera images are sharp again" in told


@pytest.mark.thorough
@pytest.mark.usefixtures("page")
def test_its_suite_is_run_as_a_campaign_and_recomputed(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--suite", "heights", "--managers", "none,Level=levelling.py:Levelling", "--repetitions", "1")
    extension = ("--extension", "altimeter.py")
    bench = [
        "bench",
        *words,
        "--no-references",
        "--no-score",
        *SHORT,
        *extension,
        "--out",
        "campaign",
        "--jobs",
        "2",
    ]
    assert main(bench) == 0
    printed = capsys.readouterr()
    assert "Level" in printed.out
    assert "sunset bundle campaign --out results.zip --extension altimeter.py" in printed.err
    assert main(["report", "campaign", "--recompute", *extension]) == 0
    again = capsys.readouterr()
    assert "differ" not in again.err
    assert main(bench) == 0  # it is the same campaign, of which all runs are there
    assert main([word for word in bench if word not in extension]) == 2
    assert "no suite 'heights'" in capsys.readouterr().err


@pytest.mark.thorough
@pytest.mark.usefixtures("page")
def test_a_managing_system_for_it_is_checked(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["levelling.py:Levelling", "--scenario", "altimeter_drift", "--extension", "altimeter.py", *SHORT]
    assert main(["managers", "check", *words]) == 0
    assert "deterministic    yes" in capsys.readouterr().out


@pytest.mark.thorough
@pytest.mark.xdist_group("live")
@pytest.mark.usefixtures("page")
def test_it_is_run_live(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--extension", "altimeter.py", "--duration", "8", "--out", "drift", "--middleware", "cyclonedds")
    summary = run_summary("altimeter_drift", "--manager", "levelling.py:Levelling", *words, capsys=capsys)
    metrics = summary["metrics"]
    assert isinstance(metrics, dict)
    assert metrics["episodes_resolved"] >= 1

    assert main(["report", "drift", "--extension", "altimeter.py"]) == 0
    assert "F6 the height is plausible again" in capsys.readouterr().out


@pytest.mark.thorough
@pytest.mark.xdist_group("processes")
@pytest.mark.usefixtures("page")
def test_its_node_is_up_its_fault_injected_and_a_redeploy_cures_it() -> None:
    with going_up("--extension", "altimeter.py", "--scenario", "altimeter_drift") as (up, tool):
        assert up.tells("The faults are injected")
        name = "/managed_subsystem/altimeter"

        def drift() -> float:
            request = GetParameters.Request(names=["altimeter_drift"])
            (value,) = tool.call(GetParameters, f"{name}/get_parameters", request).values
            strength: float = value.double_value
            return strength

        assert drift() == 800.0
        before = up.pids["altimeter"]
        assert tool.call(Redeploy, "/launcher/redeploy", Redeploy.Request(node="altimeter")).success
        assert eventually(lambda: up.pids["altimeter"] != before)
        assert eventually(lambda: up.state("altimeter").startswith("active"))
        assert not exists(before)
        assert drift() == 0.0

        injection = Parameter("altimeter_drift", value=600.0).to_parameter_msg()
        request = SetParameters.Request(parameters=[injection])
        (result,) = tool.call(SetParameters, f"{name}/set_parameters", request).results
        assert result.successful
        assert drift() == 600.0
