import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import onnxruntime
import pytest

from sunset.errors import ModelError
from sunset.perception import Modality, Model, ModelCard, Segmenter, list_models, load_model

Frame = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16]]


def test_the_shipped_model_is_listed_and_loads_by_name(lite: Model) -> None:
    assert lite.card.name == "lite"
    assert "lite" in list_models()


def test_a_model_loads_from_a_folder(copied: Path, lite: Model) -> None:
    assert load_model(copied).card == lite.card
    assert load_model(str(copied)).card == lite.card


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ModelError, match=r"There is no model 'heavy': name a folder .* one of .*lite"):
        load_model("heavy")


def test_a_missing_network_is_named(copied: Path) -> None:
    (copied / "depth.onnx").unlink()
    with pytest.raises(ModelError, match=r"The file .*depth\.onnx, named on .* No such file or directory\."):
        load_model(copied)


def test_a_truncated_network_is_told_from_the_card(copied: Path) -> None:
    path = copied / "rgb.onnx"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ModelError, match=r"The file .*rgb\.onnx is not the one on the model's card"):
        load_model(copied)


def constant(labels: str = "uint8[144, 256]", entropy: str = "float", value: str = "Identity(half)") -> bytes:
    """A network that gives the same whatever it sees; the arguments are in ONNX's own notation."""
    kind, _, sides = labels.partition("[")
    parser = pytest.importorskip("onnx.parser")
    network = parser.parse_model(f"""
        <ir_version: 9, opset_import: ["" : 18]>
        graph (uint8[144, 256, 3] bgr) => (float[1, 28, 1, 1] logits, {labels} labels, {entropy} entropy) {{
            small = Constant<value_ints = [1, 28, 1, 1]>()
            logits = ConstantOfShape(small)
            size = Constant<value_ints = [{sides}>()
            labels = ConstantOfShape<value = {kind}[1] {{0}}>(size)
            half = Constant<value_float = 0.5>()
            below = Neg(half)
            one = Constant<value_ints = [1]>()
            entropy = {value}
        }}
    """)
    return bytes(network.SerializeToString())


@pytest.fixture
def with_network(copied: Path) -> Callable[[bytes], Path]:
    """Put other bytes in the place of rgb.onnx, with their checksum on the card."""

    def exchange(content: bytes) -> Path:
        (copied / "rgb.onnx").write_bytes(content)
        path = copied / "card.json"
        raw = json.loads(path.read_text(encoding="utf-8"))
        raw["networks"]["rgb"]["sha256"] = hashlib.sha256(content).hexdigest()
        path.write_text(json.dumps(raw), encoding="utf-8")
        return copied

    return exchange


def checksum(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_weights_in_the_networks_own_file_answer_as_those_in_a_file_beside_it(
    copied: Path, lite: Model, frame: Frame
) -> None:
    assert lite.card.networks[Modality.RGB].data
    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    options.optimized_model_filepath = str(copied / "whole.onnx")
    beside = "session.optimized_model_external_initializers"
    options.add_session_config_entry(f"{beside}_file_name", "unused.bin")
    options.add_session_config_entry(f"{beside}_min_size_in_bytes", "1000000000")  # so nothing goes there
    onnxruntime.InferenceSession(copied / "rgb.onnx", options, providers=["CPUExecutionProvider"])
    network = replace(
        lite.card.networks[Modality.RGB], file="whole.onnx", sha256=checksum(copied / "whole.onnx"), data={}
    )
    replace(lite.card, networks={Modality.RGB: network}).write(copied)
    for name in ("rgb.onnx", "rgb.bin"):
        (copied / name).unlink()
    answer = Segmenter(load_model(copied)).segment(Modality.RGB, *frame)
    expected = Segmenter(lite).segment(Modality.RGB, *frame)
    assert answer.entropy == expected.entropy
    assert np.array_equal(answer.labels, expected.labels)


def test_damaged_weights_beside_a_network_are_told_from_the_card(copied: Path) -> None:
    content = bytearray((copied / "rgb.bin").read_bytes())
    content[1000] ^= 1
    (copied / "rgb.bin").write_bytes(content)
    with pytest.raises(
        ModelError, match=r"The file .*rgb\.bin is not the one on .*; it is damaged or was exchanged\."
    ):
        load_model(copied)


def test_missing_weights_beside_a_network_are_named(copied: Path) -> None:
    (copied / "rgb.bin").unlink()
    with pytest.raises(ModelError, match=r"The file .*rgb\.bin, named on .* No such file or directory\."):
        load_model(copied)


NOT_ON_THE_CARD = (
    r"rgb\.onnx is no ONNX model that can be run: .*; weights in other files .* network's 'data'\.$"
)


def test_weights_that_the_card_does_not_name_are_refused(copied: Path) -> None:
    card = ModelCard.read(copied / "card.json")
    network = replace(card.networks[Modality.RGB], data={})
    replace(card, networks={Modality.RGB: network}).write(copied)
    with pytest.raises(ModelError, match=NOT_ON_THE_CARD):
        load_model(copied).session(Modality.RGB)


def test_weights_that_a_network_names_in_a_longer_encoding_are_refused(
    copied: Path, with_network: Callable[[bytes], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copyfile(copied / "rgb.bin", copied / "my.bin")
    monkeypatch.chdir(copied)
    content = (copied / "rgb.onnx").read_bytes()
    # one byte less of the name, one byte more of its length, a varint that means 6
    longer = content.replace(b"\x12\x07rgb.bin", b"\x12\x86\x00my.bin")
    assert longer != content
    with pytest.raises(ModelError, match=NOT_ON_THE_CARD):
        load_model(with_network(longer)).session(Modality.RGB)


@pytest.mark.thorough
def test_a_file_exchanged_after_the_model_was_loaded_is_told_from_the_card(
    with_network: Callable[[bytes], Path],
) -> None:
    folder = with_network(constant())
    model = load_model(folder)
    (folder / "rgb.onnx").write_bytes(b"another one")
    with pytest.raises(ModelError, match=r"The file .*rgb\.onnx is not the one on the model's card"):
        model.session(Modality.RGB)


def test_weights_cut_short_are_refused_though_the_card_has_their_checksum(copied: Path) -> None:
    path = copied / "rgb.bin"
    path.write_bytes(path.read_bytes()[:1000])
    card = ModelCard.read(copied / "card.json")
    network = replace(card.networks[Modality.RGB], data={"rgb.bin": checksum(path)})
    replace(card, networks={Modality.RGB: network}).write(copied)
    with pytest.raises(ModelError, match=r"The network .*rgb\.onnx is no ONNX model that can be run: .*\.$"):
        load_model(copied).session(Modality.RGB)


@pytest.mark.parametrize("content", [b"", b"no network", b"\x08\x09" * 50])
def test_what_is_no_network_is_refused(with_network: Callable[[bytes], Path], content: bytes) -> None:
    model = load_model(with_network(content))
    with pytest.raises(ModelError, match=r"The network .*rgb\.onnx (is no ONNX model|must take|lacks)"):
        model.session(Modality.RGB)


def test_a_network_cut_short_is_refused(with_network: Callable[[bytes], Path], lite: Model) -> None:
    content = (lite.folder / "rgb.onnx").read_bytes()
    model = load_model(with_network(content[: len(content) // 2]))
    with pytest.raises(ModelError, match=r"The network .*rgb\.onnx is no ONNX model that can be run: .*\.$"):
        model.session(Modality.RGB)


def test_a_network_of_another_modality_is_refused(edit_card: Callable[..., Path], lite: Model) -> None:
    networks = lite.card.to_json()["networks"]
    assert isinstance(networks, dict)
    model = load_model(edit_card(networks={"rgb": networks["depth"]}))
    with pytest.raises(ModelError, match=r"must take bgr tensor\(uint8\) \[144, 256, 3\], but takes depth"):
        model.session(Modality.RGB)


def test_a_card_of_another_size_than_the_network_is_refused(edit_card: Callable[..., Path]) -> None:
    model = load_model(edit_card(height=288, width=512))
    model_card_size = "must take depth tensor(uint16) [288, 512], but takes depth tensor(uint16) [144, 256]"
    with pytest.raises(ModelError) as caught:
        model.session(Modality.DEPTH)
    assert model_card_size in str(caught.value)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("network", "words"),
    [
        ({"labels": "int64[144, 256]"}, "but gives labels tensor(int64) [144, 256] and entropy"),
        ({"labels": "uint8[72, 128]"}, "but gives labels tensor(uint8) [72, 128] and entropy"),
        (
            {"entropy": "float[1]", "value": "ConstantOfShape(one)"},
            "and entropy tensor(float) [1].",
        ),
    ],
)
def test_a_network_with_outputs_of_another_kind_is_refused(
    network: dict[str, str], words: str, with_network: Callable[[bytes], Path]
) -> None:
    model = load_model(with_network(constant(**network)))
    with pytest.raises(ModelError, match=r"rgb\.onnx must give labels .* and entropy") as caught:
        model.session(Modality.RGB)
    assert words in str(caught.value)


@pytest.mark.thorough
@pytest.mark.parametrize(("value", "words"), [("Log(below)", "got nan"), ("Exp(half)", "got 1.64")])
def test_an_entropy_that_is_none_is_refused(
    value: str, words: str, with_network: Callable[[bytes], Path], frame: Frame
) -> None:
    good = Segmenter(load_model(with_network(constant())))
    assert good.segment(Modality.RGB, *frame).entropy == 0.5
    segmenter = Segmenter(load_model(with_network(constant(value=value))))
    with pytest.raises(ModelError, match=f"must give an entropy from 0 to 1, {words}"):
        segmenter.segment(Modality.RGB, *frame)


def test_a_modality_without_network_is_refused(edit_card: Callable[..., Path], lite: Model) -> None:
    networks = lite.card.to_json()["networks"]
    assert isinstance(networks, dict)
    folder = edit_card(networks={"rgb": networks["rgb"]})
    with pytest.raises(ModelError, match="The model 'lite' has no network 'fusion', only rgb"):
        load_model(folder).session(Modality.FUSION)


def test_a_session_is_made_once_per_process(copied: Path, lite: Model) -> None:
    assert lite.session(Modality.RGB) is load_model(copied).session(Modality.RGB)
