from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, ModelError
from sunset.perception import Modality, Model, ModelCard, NetworkCard
from sunset.perception.card import check_name


def test_the_card_that_is_read_is_the_card_that_was_written(tmp_path: Path, lite: Model) -> None:
    lite.card.write(tmp_path)
    assert ModelCard.read(tmp_path / "card.json") == lite.card


def test_what_a_card_may_say_besides_is_read_and_written(tmp_path: Path, lite: Model) -> None:
    networks = {
        modality: replace(network, data={"all.data": "0" * 64})
        for modality, network in lite.card.networks.items()
    }
    card = replace(lite.card, networks=networks, architecture="lite", precision="float16 weights")
    card.write(tmp_path)
    assert ModelCard.read(tmp_path / "card.json") == card
    assert "float16 weights" in (tmp_path / "card.md").read_text(encoding="utf-8")


def test_what_a_terminal_would_obey_in_a_card_is_shown_instead(tmp_path: Path, lite: Model) -> None:
    replace(lite.card, description="\x1b]0;owned\x07 towns", results={"\x1b[2J": ["\x9b1A"]}).write(tmp_path)
    text = ModelCard.read(tmp_path / "card.json").to_text()
    assert not {c for c in text if not c.isprintable()} - {"\n"}
    assert r"\x1b]0;owned\x07 towns" in text


def test_a_networks_digest_tells_its_weights_files_apart() -> None:
    plain = NetworkCard("rgb.onnx", "0" * 64, 1, 1.0)
    assert plain.digest == plain.sha256
    one = replace(plain, data={"a": "1" * 64, "b": "2" * 64})
    other = replace(plain, data={"a": "2" * 64, "b": "1" * 64})
    assert len({plain.digest, one.digest, other.digest}) == 3
    assert one.files == {"rgb.onnx": "0" * 64, "a": "1" * 64, "b": "2" * 64}


def test_the_card_for_reading_says_what_the_card_says(tmp_path: Path, lite: Model) -> None:
    lite.card.write(tmp_path)
    text = (tmp_path / "card.md").read_text(encoding="utf-8")
    assert text.startswith(f"# lite, version {lite.card.version}\n")
    networks = text.partition("\n## Networks\n")[2].partition("\n## ")[0]
    for modality, network in lite.card.networks.items():
        section = networks.partition(f"\n### {modality.key.capitalize()}\n")[2].partition("\n### ")[0]
        assert f"- file: {network.file}\n- sha256: {network.sha256}\n" in section
        for name, digest in network.data.items():
            assert f"- {name}: {digest}\n" in section


def test_networks_without_files_beside_them_are_a_table_in_the_card_for_reading(lite: Model) -> None:
    networks = {modality: replace(network, data={}) for modality, network in lite.card.networks.items()}
    text = replace(lite.card, networks=networks).to_text()
    for network in networks.values():
        assert f"| {network.file} | {network.sha256} |" in text


def test_the_shipped_card_has_all_networks_classes_and_usable_thresholds(lite: Model) -> None:
    assert set(lite.card.networks) == set(Modality)
    assert lite.card.classes == CLASSES
    assert 0 < lite.card.entropy_threshold < 1
    assert lite.card.sharpness_threshold > 0


def test_the_shipped_weights_fit_into_20_megabytes(lite: Model) -> None:
    files = {name for network in lite.card.networks.values() for name in network.files}
    assert sum((lite.folder / name).stat().st_size for name in files) <= 20e6


def test_a_missing_card_is_named(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"The model card .*card\.json is missing\."):
        ModelCard.read(tmp_path / "card.json")


@pytest.mark.parametrize(
    "text",
    ["", '{"name": ', "[" * 100_000, '{"training": NaN}', '{"training": 1e999}', '{"name": "\\udcff"}'],
)
def test_a_card_that_is_no_json_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "card.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError, match="cannot be read as JSON"):
        ModelCard.read(path)


def test_a_card_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "card.json"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(ModelError, match="cannot be read as JSON"):
        ModelCard.read(path)


def test_a_card_that_is_a_list_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "card.json"
    path.write_text("[]", encoding="utf-8")
    with pytest.raises(ModelError, match=r"The model card .*card\.json must be an object, got \[\]"):
        ModelCard.read(path)


NETWORK = {"file": "rgb.onnx", "sha256": "0" * 64, "parameters": 1, "temperature": 1.0}


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"format": 2}, "format in the model card CARD must be 1, got 2;"),
        ({"name": ""}, "The name in the model card CARD must be a text, got '';"),
        (
            {"height": 14.4},
            "The height in the model card CARD must be a whole number from 1 to 4096, got 14.4;",
        ),
        (
            {"width": True},
            "The width in the model card CARD must be a whole number from 1 to 4096, got True;",
        ),
        (
            {"height": 31623, "width": 31623},
            "The height in the model card CARD must be a whole number from 1 to 4096, got 31623;",
        ),
        ({"classes": ["road"]}, "The classes in the model card CARD must be the 28 classes in their order;"),
        (
            {"entropy_threshold": 1.5},
            "The entropy_threshold in the model card CARD must be a number from 0 to 1, got 1.5;",
        ),
        (
            {"entropy_threshold": "low"},
            "The entropy_threshold in the model card CARD must be a number from 0 to 1, got 'low';",
        ),
        (
            {"sharpness_threshold": -1},
            "The sharpness_threshold in the model card CARD must be a number from 0 to 64, got -1;",
        ),
        (
            {"networks": {}},
            "The networks in the model card CARD must be at least one, named depth, fusion, rgb only, got none;",
        ),
        ({"networks": {"lidar": NETWORK}}, "named depth, fusion, rgb only, got lidar;"),
        (
            {"networks": {"rgb": 7}},
            "The networks.rgb in the model card CARD must be an object, got 7;",
        ),
        (
            {"networks": {"rgb": {**NETWORK, "file": "../rgb.onnx"}}},
            "The networks.rgb.file in the model card CARD must be a plain file name, without folders, got '../rgb",
        ),
        (
            {"networks": {"rgb": {**NETWORK, "sha256": "abc"}}},
            "The networks.rgb.sha256 in the model card CARD must be 64 hexadecimal digits, got 'abc';",
        ),
        (
            {"networks": {"rgb": {**NETWORK, "temperature": 0}}},
            "networks.rgb.temperature in the model card CARD must be a number from 0.001 to 1000, got 0;",
        ),
        (
            {"networks": {"rgb": {**NETWORK, "data": {"../all.data": "0" * 64}}}},
            "must be a plain file name, without folders, got '../all.data';",
        ),
        (
            {"networks": {"rgb": {**NETWORK, "data": {"all.data": "abc"}}}},
            "The networks.rgb.data.all.data in the model card CARD must be 64 hexadecimal digits, got 'abc';",
        ),
        (
            {"networks": {"rgb": {**NETWORK, "data": None}}},
            "The networks.rgb.data in the model card CARD must be an object, got None;",
        ),
        ({"architecture": 7}, "The architecture in the model card CARD must be a text, got 7;"),
        ({"precision": None}, "The precision in the model card CARD must be a text, got None;"),
        ({"training": None}, "The training in the model card CARD must be an object, got None;"),
    ],
)
def test_a_malformed_card_says_where_what_was_expected_and_what_it_got(
    edit_card: Callable[..., Path], fields: dict[str, object], message: str
) -> None:
    folder = edit_card(**fields)
    with pytest.raises(ModelError) as caught:
        ModelCard.read(folder / "card.json")
    assert message in str(caught.value).replace(str(folder / "card.json"), "CARD")
    assert str(caught.value).endswith("; correct the card, or take another model.")


@pytest.mark.parametrize("name", ["", "a\udcff"])
def test_a_name_that_a_card_cannot_hold_is_refused(name: str) -> None:
    with pytest.raises(InvalidInputError, match="must be a text that UTF-8 can encode, got '"):
        check_name(name)
