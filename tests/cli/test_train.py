from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.cli.train import _TimeIsUpError, _until
from sunset.perception import Model, load_model
from sunset.training import TrainingConfig

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


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [("--steps", "9" * 400, "at most 1000000000 steps"), ("--name", "a\udcff", "UTF-8")],
)
def test_a_training_that_cannot_end_well_is_refused(
    option: str, value: str, expected: str, complaint: Complaint
) -> None:
    assert expected in complaint(["train", "--out", "model", option, value])


def test_a_training_ends_when_its_time_is_over() -> None:
    steps: list[int] = []
    times = iter((0.0, 59.0, 60.0))
    update = _until(1, lambda _, done, *__: steps.append(done), lambda: next(times))
    update("rgb", 1, 400)
    with pytest.raises(_TimeIsUpError):
        update("rgb", 2, 400)
    assert steps == [1, 2]


def test_a_training_that_is_stopped_by_its_time_says_how_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def training(*_: object, progress: Callable[..., None], **__: object) -> None:
        progress("rgb", 1, 2)

    monkeypatch.setattr("sunset.cli.train.train_model", training)
    monkeypatch.setattr("sunset.cli.train._until", lambda _, progress: _until(0, progress))
    assert main(["train", "--out", str(tmp_path / "model"), "--minutes", "9"]) == 1
    assert (
        "The 9 min are over; the same command with --resume continues the training."
        in capsys.readouterr().err
    )


@pytest.mark.parametrize(("named", "name"), [([], "mine"), (["--name", "better"], "better")])
def test_a_trained_model_has_the_name_of_its_folder_unless_it_is_given_one(
    named: list[str], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = []

    def training(config: TrainingConfig, *_: object, **__: object) -> Model:
        names.append(config.name)
        return load_model("lite")

    monkeypatch.setattr("sunset.training.run.train", training)
    assert main(["train", "--out", str(tmp_path / "mine"), *named]) == 0
    assert names == [name]
