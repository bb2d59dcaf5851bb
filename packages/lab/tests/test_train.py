import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace

import pytest

from sunset.cli import main
from sunset.perception import Model, load_model
from sunset_lab import TrainingConfig

Complaint = Callable[[Sequence[str]], str]


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("--model", "deep", "'lite', 'reference'"),
        ("--modality", "lidar", "'all', 'rgb', 'depth', 'fusion'"),
        ("--steps", "0", "at least 1"),
        ("--frames", "0", "at least 1"),
        ("--minutes", "0", "at least 1"),
        ("--device", "tpu", "'cpu', 'cuda', 'auto'"),
    ],
)
def test_a_training_that_there_is_not_is_refused(
    option: str, value: str, expected: str, complaint: Complaint
) -> None:
    sentence = complaint(["train", "--out", "model", option, value])
    assert option in sentence
    assert value in sentence
    assert expected.replace("'", "") in sentence.replace("'", "")


def test_a_name_that_no_card_can_hold_is_refused(complaint: Complaint) -> None:
    assert "UTF-8" in complaint(["train", "--out", "model", "--name", "a\udcff"])


def test_a_training_that_is_stopped_by_its_time_says_how_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    steps = []
    times = iter((0.0, 9 * 60 - 1.0, 9 * 60.0))

    def training(*_: object, progress: Callable[..., None], **__: object) -> None:
        for step in range(1, 400):
            steps.append(step)
            progress("rgb", step, 400)

    monkeypatch.setattr("sunset.train_model", training)
    monkeypatch.setattr("sunset_lab.verbs.train.monotonic", lambda: next(times))
    assert main(["train", "--out", str(tmp_path / "model"), "--minutes", "9"]) == 1
    assert steps == [1, 2]
    assert (
        "The 9 min are over; the same command with --resume continues the training."
        in capsys.readouterr().err
    )


@pytest.mark.parametrize(("named", "name"), [([], "mine"), (["--name", "better"], "better")])
def test_a_trained_model_has_the_name_of_its_folder_unless_it_is_given_one(
    named: list[str], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = []

    def train(config: TrainingConfig, *_: object) -> Model:
        names.append(config.name)
        return load_model("lite")

    monkeypatch.setattr("sunset_lab.models._check_extra", lambda *_: None)
    monkeypatch.setitem(sys.modules, "sunset_lab.run", SimpleNamespace(train=train))
    monkeypatch.setitem(
        sys.modules, "sunset_lab.stage", SimpleNamespace(Training=lambda config, *_, **__: config)
    )
    assert main(["train", "--out", str(tmp_path / "mine"), *named]) == 0
    assert names == [name]
