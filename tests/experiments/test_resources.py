"""What a run is made with is found, opened and tried before the run begins."""

import hashlib
import json
import shutil
from pathlib import Path

import pytest

from sunset.data import DEFAULT_FLIGHT, FlightPlan, flight_place
from sunset.errors import ModelError
from sunset.experiments import RunSpec, Settings, prepare
from sunset.perception import load_model
from sunset.scenarios import Scenario


@pytest.mark.parametrize("cache", [True, False])
@pytest.mark.parametrize("modality", ["rgb", "depth", "fusion"])
def test_a_network_that_cannot_be_run_is_refused_before_the_flight(
    modality: str, cache: bool, flight: Path, tmp_path: Path
) -> None:
    folder = Path(shutil.copytree(load_model("lite").folder, tmp_path / "broken"))
    content = (folder / f"{modality}.onnx").read_bytes()[:-1000]
    (folder / f"{modality}.onnx").write_bytes(content)
    card = json.loads((folder / "card.json").read_text(encoding="utf-8"))
    card["networks"][modality]["sha256"] = hashlib.sha256(content).hexdigest()
    (folder / "card.json").write_text(json.dumps(card), encoding="utf-8")

    with pytest.raises(ModelError, match=rf"The network .*{modality}\.onnx is no ONNX model that can be run"):
        prepare(
            RunSpec(
                scenario=Scenario("none"),
                manager="none",
                settings=Settings(model=str(folder), bag=flight, cache=cache),
            )
        )


def test_a_network_that_answered_once_is_not_opened_again(
    flight: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path))
    shutil.copytree(flight.parent, flight_place(DEFAULT_FLIGHT).parent)
    spec = RunSpec(scenario=Scenario("none"), manager="none")
    first = prepare(spec)
    frame = first.bag.frame(0)
    monkeypatch.setattr("sunset.perception.model._sessions", {})
    monkeypatch.setattr("sunset.perception.model.open_session", None)
    for modality in first.model.card.networks:
        prepare(spec).segmenter.segment(modality, frame.rgb, frame.depth)


def test_a_flight_whose_cache_was_deleted_meanwhile_is_rendered_again(
    flight: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "cache"))
    rendered: list[Path] = []

    def render(plans: list[FlightPlan], **_: object) -> None:
        rendered.extend(shutil.copytree(flight, flight_place(plan)) for plan in plans)

    monkeypatch.setattr("sunset.experiments.resources.flight_bags", render)
    spec = RunSpec(scenario=Scenario("none"), manager="none")
    prepare(spec)
    shutil.rmtree(tmp_path / "cache")
    assert len(prepare(spec).bag) == 400
    assert len(rendered) == 2
