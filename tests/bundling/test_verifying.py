"""What was changed in a bundle is found and named, even where the list of checksums was changed along."""

import json
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from tests.bundling.conftest import DATE, IMPORTED, SETTINGS, Forge

from sunset.api.splits import generate_split
from sunset.bundling import Rerun, bundle, verify
from sunset.experiments import BenchSpec, bench
from sunset.interfaces import serialize
from sunset.interfaces.system_interfaces.msg import FrameEvaluation
from sunset.recording import describes_bag, read_plan
from sunset.recording._bag import read_bag, write_bag
from sunset.recording.values import Payload, digest_of
from sunset.seeding import drawn_seed
from sunset.system import extended_system

pytestmark = pytest.mark.xdist_group("bundling")

NOTHING = Rerun(0, 1)
ALL = Rerun(99, 1)
WET = "campaign/runs/own/none/wet/seed-1"
OTHER_SEED = "campaign/runs/own/none/wet/seed-2"
MINE = "campaign/runs/own/mine/wet/seed-1"

Edit = Callable[[Path], object]


def changed(file: str, **values: object) -> Edit:
    """Return what changes keys of a JSON file; those of dictionaries in it by `outer__inner`; `...` removes one."""

    def edit(folder: Path) -> None:
        content = json.loads((folder / file).read_text())
        for name, value in values.items():
            inner: Any = content
            *outer, last = name.split("__")
            for key in outer:
                inner = inner[int(key) if key.isdecimal() else key]
            inner[last] = value
            if value is ...:
                del inner[last]
        (folder / file).write_text(json.dumps(content))

    return edit


def replaced(run: str, by: str) -> Edit:
    """Return what puts the record of one run in the place of another's."""

    def edit(folder: Path) -> None:
        shutil.rmtree(folder / run)
        shutil.copytree(folder / by, folder / run)

    return edit


def swapped(folder: Path) -> None:
    (folder / WET).rename(folder / "aside")
    (folder / OTHER_SEED).rename(folder / WET)
    (folder / "aside").rename(folder / OTHER_SEED)


def disguised(folder: Path) -> None:
    """Give the run of one seed the messages of the other, and let its file say that it is of its own."""
    replaced(WET, OTHER_SEED)(folder)
    changed(f"{WET}/run.json", seed=1)(folder)


def with_messages(edit: Callable[[list[Payload]], list[Payload]], *, digest: bool) -> Edit:
    """Return what changes the messages of a run, and its digest too if that is asked for."""

    def apply(folder: Path) -> None:
        payloads = edit(list(read_bag(folder / WET)))
        for name in ("messages.mcap", "metadata.yaml"):
            (folder / WET / name).unlink()
        write_bag(folder / WET, payloads)
        if digest:
            changed(f"{WET}/run.json", digest=digest_of(payloads))(folder)

    return apply


def without_last_clock(payloads: list[Payload]) -> list[Payload]:
    last = max(place for place, payload in enumerate(payloads) if payload.topic == "/clock")
    return payloads[:last] + payloads[last + 1 :]


def without(topic: str, *, last: bool = False) -> Callable[[list[Payload]], list[Payload]]:
    """Return what removes the messages on a topic, or the last one of them."""

    def edit(payloads: list[Payload]) -> list[Payload]:
        gone = [payload for payload in payloads if payload.topic == topic]
        assert gone, sorted({payload.topic for payload in payloads})
        return [payload for payload in payloads if payload not in (gone[-1:] if last else gone)]

    return edit


def praised(payloads: list[Payload]) -> list[Payload]:
    """Let every frame's IoU be larger than the pixels say that are counted beside it."""
    edited = []
    for payload in payloads:
        message = payload.decoded().message
        if isinstance(message, FrameEvaluation):
            message.iou *= 1.8
            edited.append(Payload(payload.topic, payload.type, payload.time_ns, serialize(message)))
        else:
            edited.append(payload)
    return edited


def flipped(folder: Path) -> None:
    file = folder / WET / "messages.mcap"
    content = bytearray(file.read_bytes())
    chunk = 17 + int.from_bytes(
        content[9:17], "little"
    )  # behind magic and header record; messages are at its end
    content[chunk + int.from_bytes(content[chunk + 1 : chunk + 9], "little") - 53] ^= 0xFF
    file.write_bytes(content)


def longer(folder: Path) -> None:
    """Let the plan and all runs say that more was measured than was."""
    changed("campaign/bench.json", timing__duration_s=4.0)(folder)
    for file in (folder / "campaign").glob("runs/*/*/*/*/run.json"):
        changed(str(file.relative_to(folder)), duration_s=4.0, expected_frames=40)(folder)


def appended(name: str, text: str = "# changed\n") -> Edit:
    def edit(folder: Path) -> None:
        with (folder / name).open("a") as file:
            file.write(text)

    return edit


def test_what_is_run_for_the_score_is_verified_too(flight: Path, tmp_path: Path) -> None:
    assert flight.exists()
    spec = BenchSpec(
        suite="single",
        scenarios=("gpu_failure",),
        managers=("baseline",),
        references=False,
        repetitions=1,
        settings=SETTINGS,
    )
    bench(spec, tmp_path / "results", jobs=1)
    bundle(tmp_path / "results", tmp_path / "results.zip", published=DATE)

    found = verify(tmp_path / "results.zip", NOTHING)

    assert found.problems == ()
    assert sorted(read_plan(tmp_path / "results").manager_checksums) == ["baseline", "none", "oracle"]


FORGERIES: dict[str, tuple[Edit, str, str]] = {
    "figure": (
        changed(f"{WET}/run.json", metrics__t_down_s=0.5),
        WET,
        "its t_down_s is stored as 0.5, and the messages give 2",
    ),
    "figure that is not applicable": (
        changed(f"{WET}/run.json", metrics__t_react_s=1.0),
        WET,
        "its t_react_s is stored as 1, and the messages give N/A",
    ),
    "figure by the paper's evaluation script": (
        changed(f"{WET}/run.json", by_paper_script__succeeded=9),
        WET,
        "its figures by the paper's evaluation script are stored otherwise than the messages give them",
    ),
    "figure that is missing": (changed(f"{WET}/run.json", metrics={}), WET, "must be"),
    "damaged messages": (flipped, WET, "is damaged: "),
    "message": (with_messages(without_last_clock, digest=False), WET, "gives the digest"),
    "digest": (changed(f"{WET}/run.json", digest="0" * 64), WET, "gives the digest 000"),
    "record of another run": (
        replaced(WET, OTHER_SEED),
        WET,
        "its seed is 2, and that of the plan 1",
    ),
    "record of another managing system": (
        replaced(WET, MINE),
        WET,
        "its manager is 'mine', and that of the plan 'none'",
    ),
    "record of another run with its seed": (
        disguised,
        WET,
        f"its seed is stored as 1, which gives /managed_subsystem/depth {drawn_seed(1, 'depth')}, and the messages",
    ),
    "swapped runs": (swapped, OTHER_SEED, "its seed is 1, and that of the plan 2"),
    "scenario": (
        changed(f"{WET}/run.json", faults=[{"name": "image_shift", "value": 7}]),
        WET,
        "its faults are stored as image_shift (7), and the messages say gpu_failure (true)",
    ),
    "missing run": (lambda folder: shutil.rmtree(folder / MINE), MINE, "the run is missing"),
    "run too many": (
        lambda folder: shutil.copytree(folder / WET, folder / WET.replace("seed-1", "seed-3")),
        WET.replace("seed-1", "seed-3"),
        "the run is not part of the plan",
    ),
    "plan of fewer runs": (
        changed("campaign/bench.json", repetitions=1, runs=2),
        OTHER_SEED,
        "the run is not part of the plan",
    ),
    "plan of another number": (
        changed("campaign/bench.json", runs=3),
        "campaign/bench.json",
        "it was changed, or is of another version's suite",
    ),
    "plan of other scenarios": (
        appended("scenarios/wet.yaml", "description: dry\n"),
        "campaign/bench.json",
        "it was changed, or is of another version's suite",
    ),
    "plan of no campaign": (
        changed("campaign/bench.json", repetitions=10**9),
        "campaign/bench.json",
        "it describes no campaign: No campaign has 2 managing systems and 1000000000 repetitions.",
    ),
    "plan of another flight": (
        changed("campaign/bench.json", bag_checksum="0" * 64),
        WET,
        "its bag_checksum is ",
    ),
    "duration": (longer, WET, "its duration is stored as 4 s, and the messages say 2 s"),
    "injection": (
        changed(f"{WET}/run.json", start_ns=1),
        WET,
        "its injection is stored as 1 ns, and the messages say ",
    ),
    "threshold": (
        changed(f"{WET}/run.json", entropy_threshold=0.9),
        WET,
        "its entropy_threshold is 0.9, and that of the plan 0.2",
    ),
    "model": (
        changed("model/card.json", entropy_threshold=0.9),
        "campaign/bench.json",
        "its model differs from the card that is there",
    ),
    "versions": (
        changed(f"{WET}/run.json", versions={"sunset": "0.1.0"}),
        WET,
        "its version of machine is nothing, and that of the plan ",
    ),
    "onset of a fault": (
        changed(f"{WET}/run.json", faults__0__at=0.5),
        WET,
        "its faults[1].at is 0.5, and that of the plan 0.0",
    ),
    "scenario twice in the plan": (
        changed("campaign/bench.json", scenarios=["wet", "wet"]),
        "campaign/bench.json",
        "it was changed",
    ),
    "verdict": (
        changed(f"{WET}/run.json", valid=False),
        WET,
        "it is stored as invalid, with the reason nothing",
    ),
    "failure": (
        changed(f"{WET}/run.json", manager_failed="It raised.", valid=False, reason="It raised"),
        WET,
        "it is stored as failed, which a run of none never is",
    ),
    "source": (appended("managers/mine/mine.py"), "managers", "the source of mine (managers/mine/"),
    "source beside it": (
        appended("managers/mine/helper.py"),
        "managers",
        "the source of mine (managers/mine/",
    ),
    "source of ours": (appended("managers/none/none.py"), "managers", "the source of none (managers/none/"),
    "source of ours in the plan": (
        changed("campaign/bench.json", manager_checksums__none="0" * 64),
        "campaign/bench.json",
        "its none is not the one of SUNSET",
    ),
    "source elsewhere": (
        changed("bundle.json", managers__mine__files=["/etc/passwd"]),
        "managers",
        "the source of mine (/etc/passwd) is not what",
    ),
    "file that no bundle has": (
        lambda folder: (folder / "managers/mine/numpy.py").write_text("# in the place of another"),
        "managers/mine/numpy.py",
        "no bundle has such a file",
    ),
    "metadata of another bag": (
        lambda folder: (folder / WET / "metadata.yaml").write_text("rosbag2_bagfile_information: {}"),
        WET,
        "its metadata.yaml is missing, or is not that of its messages",
    ),
    "key that no run has": (
        changed(f"{WET}/run.json", iou=0.99),
        WET,
        "its run.json has what no run has, or a key twice",
    ),
    "figure that no run has": (
        changed(f"{WET}/run.json", metrics__iou_best=0.99),
        WET,
        "its run.json has what no run has, or a key twice",
    ),
    "key twice": (
        lambda folder: (folder / WET / "run.json").write_text(
            '{"metrics": {"iou": 0.99},' + (folder / WET / "run.json").read_text()[1:]
        ),
        WET,
        "its run.json has what no run has, or a key twice",
    ),
    "key that no plan has": (
        changed("campaign/bench.json", note="the best"),
        "campaign/bench.json",
        "it has what none has, or a key twice",
    ),
    "key that no card has": (
        changed("model/card.json", note="the best"),
        "model/card.json",
        "it has what none has, or a key twice",
    ),
    "version that only a run has": (
        changed(f"{WET}/run.json", versions__gpu="large"),
        WET,
        "it has the version of 'gpu', which the plan has not",
    ),
    "size of nothing": (changed(f"{WET}/run.json", frame_size=[-144, 256]), WET, "frame_size"),
    "version with a name of several lines": (
        changed(f"{WET}/run.json", **{"versions__a\nVerified.": "large"}),
        WET,
        "it has the version of 'a\\nVerified.', which the plan has not",
    ),
    "messages without the seed": (
        with_messages(without("/parameter_events"), digest=True),
        WET,
        "the messages do not say its seed",
    ),
    "messages that contradict themselves": (
        with_messages(praised, digest=True),
        WET,
        "messages on /seg_metrics contradict themselves: the iou of the first is ",
    ),
    "messages without the end": (
        with_messages(without("/experiment/log", last=True), digest=True),
        WET,
        "the messages do not say when its injection and its end were",
    ),
    "failure that counts": (
        changed(f"{MINE}/run.json", start_ns=..., manager_failed="It raised.", metrics__iou=0.99),
        MINE,
        "it is stored as failed, and as valid or with figures",
    ),
    "failure with messages": (
        changed(
            f"{MINE}/run.json", start_ns=..., manager_failed="It raised.", valid=False, reason="It raised"
        ),
        MINE,
        "it is stored as failed, and has messages",
    ),
    "source without a checksum": (
        changed("campaign/bench.json", manager_checksums__mine=""),
        "campaign/bench.json",
        "it has no checksum of mine, which is a file",
    ),
    "checksum of no managing system": (
        changed("campaign/bench.json", manager_checksums__ghost="0"),
        "campaign/bench.json",
        "its checksums are not those of its managing systems",
    ),
    "source of no managing system": (
        changed("bundle.json", managers__ghost={"files": [], "load": "", "folder": ""}),
        "bundle.json",
        "its managing systems and extensions are not those of the plan",
    ),
    "class that the plan does not name": (
        changed("bundle.json", managers__mine__load="managers/mine/mine.py:Other"),
        "bundle.json",
        "the sources of mine and how it is loaded do not fit ",
    ),
    "class that lies elsewhere": (
        changed("bundle.json", managers__mine__load="/elsewhere/mine.py:Mine"),
        "bundle.json",
        "the sources of mine and how it is loaded do not fit ",
    ),
    "folder that lies elsewhere": (
        changed("bundle.json", managers__mine__folder="/elsewhere"),
        "bundle.json",
        "the sources of mine and how it is loaded do not fit ",
    ),
    "table": (appended("report.txt"), "report.txt", "it is not the table of the figures"),
}


TOGETHER = (
    "figure",
    "figure that is not applicable",
    "missing run",
    "run too many",
    "plan of another flight",
    "injection",
    "model",
    "versions",
    "verdict",
    "source",
    "source beside it",
    "source of ours",
    "metadata of another bag",
    "key that no plan has",
    "key that no card has",
    "checksum of no managing system",
    "source of no managing system",
    "class that the plan does not name",
)
"""Forgeries that do not hide each other."""

SLOW = (
    "key that no run has",
    "figure that no run has",
    "key twice",
    "version that only a run has",
    "messages without the seed",
    "messages without the end",
    "failure that counts",
    "failure with messages",
    "source without a checksum",
    "class that lies elsewhere",
    "folder that lies elsewhere",
)
"""More forgeries of the same kinds."""


@pytest.mark.parametrize(
    "names",
    [
        TOGETHER,
        *(
            pytest.param((name,), marks=[pytest.mark.thorough] if name in SLOW else [])
            for name in FORGERIES
            if name not in TOGETHER
        ),
    ],
    ids=lambda names: names[0],
)
def test_forgeries_are_found_although_the_checksums_fit(
    names: tuple[str, ...], packed: Path, forge: Forge
) -> None:
    def edit(folder: Path) -> None:
        for name in names:
            FORGERIES[name][0](folder)

    found = verify(forge(packed, edit), NOTHING)

    for name in names:
        _, where, what = FORGERIES[name]
        hits = [text for text in found.problems if text.startswith(f"{where}: ") and what in text]
        assert hits, (name, found.problems)
    problems = f"{len(found.problems)} problem{'s' * (len(found.problems) > 1)}"
    assert str(found).endswith(f"\nNot verified: {problems}.")


def test_what_is_the_same_in_all_runs_is_compared_with_most_of_them(packed: Path, forge: Forge) -> None:
    found = verify(forge(packed, changed(f"{WET}/run.json", bag_dropped=7)), NOTHING)

    assert found.problems == (f"{WET}: its bag_dropped is 7, and that of the other runs 0.",)


@pytest.mark.parametrize(
    ("edit", "expected"),
    [
        (appended("README.md"), "README.md: it was changed, since its checksum is not that in SHA256SUMS."),
        (
            lambda folder: (folder / "README.md").unlink(),
            "README.md: it is missing, and stands in SHA256SUMS.",
        ),
        (lambda folder: (folder / "more").write_text(""), "more: it does not stand in SHA256SUMS."),
        (
            lambda folder: (folder / "SHA256SUMS").unlink(),
            "SHA256SUMS: it is missing, or not a text, so that nothing says what the files were.",
        ),
        (
            appended("SHA256SUMS", "# all files\n"),
            "SHA256SUMS: line 24 is '# all files', which is not a checksum and a file.",
        ),
        (
            appended("SHA256SUMS", f"{'0' * 64}  README.md\n"),
            "SHA256SUMS: line 24 names README.md, which a line before it does, too.",
        ),
    ],
)
def test_the_checksums_are_compared(edit: Edit, expected: str, packed: Path, forge: Forge) -> None:
    assert verify(forge(packed, edit, sums=False), NOTHING).problems == (expected,)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "text"),
    [("README.md", "900 runs"), ("CITATION.cff", "title: Mine"), ("ro-crate-metadata.json", "{}")],
)
def test_what_is_said_of_a_bundle_is_compared(name: str, text: str, packed: Path, forge: Forge) -> None:
    forged = forge(packed, lambda folder: (folder / name).write_text(text), texts=False)

    assert [problem.partition(":")[0] for problem in verify(forged, NOTHING).problems] == [name]


def test_a_citation_that_grows_is_refused_before_it_is_long(packed: Path, forge: Forge) -> None:
    levels = [
        f"{name}: &{name} [{', '.join([f'*{inner}'] * 9)}]" for inner, name in pairwise("abcdefghijklm")
    ]
    text = "\n".join(["a: &a [x]", *levels, "title: *m", "authors: []"])
    forged = forge(packed, lambda folder: (folder / "CITATION.cff").write_text(text), texts=False)

    (problem,) = verify(forged, NOTHING).problems

    assert problem.startswith("CITATION.cff: it is missing, or is not a citation")


@pytest.mark.parametrize(
    "text", ["a: *b", "a: !foo b", "[[[[", "a: [1", "\t", "[]", "rosbag2_bagfile_information:"]
)
def test_metadata_that_is_damaged_or_of_something_else_is_not_that_of_a_bag(
    text: str, results: Path, tmp_path: Path
) -> None:
    record = shutil.copytree(results / WET.removeprefix("campaign/"), tmp_path / "record")
    assert describes_bag(record)

    (record / "metadata.yaml").write_text(text)

    assert not describes_bag(record)


@pytest.mark.thorough
def test_a_citation_that_is_no_plain_yaml_is_not_loaded(packed: Path, forge: Forge, tmp_path: Path) -> None:
    evil = f"!!python/object/apply:os.mkdir [{tmp_path / 'made'}]"
    for text in (evil, "[" * 50_000, "x" * 200_000, "title: 2026-99-99\nauthors: [{name: 1}]"):
        forged = forge(
            packed, lambda folder, text=text: (folder / "CITATION.cff").write_text(text), texts=False
        )
        (problem,) = verify(forged, NOTHING).problems
        assert problem == "CITATION.cff: it is missing, or is not a citation that 'sunset bundle' writes."
        shutil.rmtree(tmp_path / "opened")
    assert not (tmp_path / "made").exists()


def test_what_fits_together_and_never_happened_is_found_by_running_it_again(
    packed: Path, forge: Forge
) -> None:
    forged = forge(packed, with_messages(without_last_clock, digest=True))

    assert verify(forged, NOTHING).passed
    (problem,) = verify(forged, ALL).problems
    assert problem.startswith(f"{WET}: The run in {WET} was run again, and left other messages")


def test_of_a_forged_figure_only_that_figure_is_said_to_differ_when_it_is_run_again(
    packed: Path, forge: Forge
) -> None:
    forged = forge(packed, changed(f"{WET}/run.json", metrics__t_down_s=0.5))

    again = [problem for problem in verify(forged, ALL).problems if "running it again" in problem]

    (sentence,) = again
    assert sentence.startswith(f"{WET}: Its t_down_s is stored as 0.5, and running it again gave 2")
    assert "{" not in sentence


def test_an_untouched_bundle_verifies_and_runs_none_of_its_code(
    packed: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    capfd.readouterr()

    found = verify(packed, ALL)

    assert found.passed
    assert str(found).endswith("\nVerified.")
    assert (found.recomputed, len(found.again)) == (4, 2)
    (unchecked,) = found.unchecked
    assert unchecked == (
        "2 runs could not be run again: that runs the code of mine, which the bundle has; read it, and let it run with "
        "--trust."
    )
    assert IMPORTED not in capfd.readouterr().err


def test_what_is_trusted_is_run_again_from_the_source_in_the_bundle(
    results: Path, packed: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    capfd.readouterr()
    (results.parent / "helper.py").rename(results.parent / "gone.py")
    try:
        found = verify(packed, Rerun(99, 1, trust=True))
    finally:
        (results.parent / "gone.py").rename(results.parent / "helper.py")

    assert (found.problems, found.unchecked, len(found.again)) == ((), (), 4)
    assert IMPORTED in capfd.readouterr().err


@pytest.mark.thorough
def test_the_seed_chooses_which_runs_are_run_again(packed: Path) -> None:
    chosen = {verify(packed, Rerun(1, seed)).again for seed in range(4)}

    assert chosen == {(WET.removeprefix("campaign/"),), (OTHER_SEED.removeprefix("campaign/"),)}
    assert verify(packed, Rerun(1, 3)).again in chosen


EXTENSION = f"""
import sys

from sunset.system import Extension

print("{IMPORTED}", file=sys.stderr)
EXTENSION = Extension(suites={{"dark": (("image_degradation=1.2",), ("image_degradation=1.4",))}})
"""


@pytest.mark.thorough
def test_an_extension_is_packed_and_runs_only_where_it_is_trusted(
    tmp_path: Path, forge: Forge, capfd: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / "darker.py"
    source.write_text(EXTENSION)
    packed = tmp_path / "dark.zip"
    with extended_system([source]):
        spec = BenchSpec(
            suite="dark",
            scenarios=("image_degradation=1.2",),
            managers=("none",),
            references=False,
            score=False,
            repetitions=1,
            settings=SETTINGS,
        )
        bench(spec, tmp_path / "results", jobs=1)
        bundle(tmp_path / "results", packed, published=DATE)
    capfd.readouterr()

    careful = verify(packed, ALL)

    assert IMPORTED not in capfd.readouterr().err

    trusting = verify(packed, Rerun(99, 1, trust=True))

    assert (careful.passed, careful.recomputed, careful.again) == (True, 0, ())
    assert str(careful).endswith("\nNothing is wrong, but no figure was checked.")
    assert careful.unchecked[0].endswith(
        "needs the campaign's extensions (darker.py), whose code --trust lets run."
    )
    assert careful.unchecked[1] == (
        "The table in report.txt was not compared, since that needs the campaign's extensions, too."
    )
    assert (trusting.passed, trusting.recomputed, len(trusting.again)) == (True, 1, 1)
    assert IMPORTED in capfd.readouterr().err
    forged = verify(forge(packed, appended("extensions/darker.py/darker.py")), Rerun(99, 1, trust=True))
    (problem,) = forged.problems
    assert problem == (
        "extensions: the source of darker.py (extensions/darker.py/darker.py) is not what the plan says it was run "
        "with."
    )
    assert IMPORTED not in capfd.readouterr().err
    shutil.rmtree(tmp_path / "opened")
    run = "campaign/runs/dark/none/image_degradation-1.2-"
    missing = verify(forge(packed, lambda folder: shutil.rmtree(folder / "campaign/runs")), NOTHING)
    assert "campaign/bench.json: it has 1 run, and 0 are there." in missing.problems
    shutil.rmtree(tmp_path / "opened")
    moved = verify(forge(packed, renamed), NOTHING)
    assert [
        text for text in moved.problems if text.startswith(run) and "it says that it is seed 1 of" in text
    ]
    shutil.rmtree(tmp_path / "opened")
    chosen = verify(forge(packed, of_seed_7), NOTHING)
    assert [text for text in chosen.problems if "no run of none with seed 7 is part of the plan" in text]
    assert [text for text in chosen.problems if text.endswith(": its seeds are not those of the plan.")]


def renamed(folder: Path) -> None:
    (run,) = (folder / "campaign/runs").glob("*/*/*/seed-1")
    run.rename(run.with_name("seed-7"))


def of_seed_7(folder: Path) -> None:
    renamed(folder)
    (file,) = (folder / "campaign/runs").glob("*/*/*/seed-7/run.json")
    changed(str(file.relative_to(folder)), seed=7)(folder)


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
def test_a_campaign_on_a_split_keeps_what_pins_it(tmp_path: Path, forge: Forge) -> None:
    described = generate_split("train", 1, tmp_path / "split", seed=4)
    bench(
        BenchSpec(
            suite=str(tmp_path / "split"), managers=("none",), references=False, score=False, repetitions=1
        ),
        tmp_path / "results",
        jobs=1,
    )
    bundle(tmp_path / "results", out := tmp_path / "results.zip", published=DATE)

    assert read_plan(tmp_path / "results").split == described.sha256
    assert verify(out, NOTHING).passed
    for edit, finding in (
        (lambda folder: (folder / "scenarios/split.json").unlink(), "bench.json: it was changed"),
        (changed("scenarios/split.json", sha256="0" * 64), "are not those of its split.json"),
        (changed("campaign/bench.json", split="0" * 64), "bench.json: it was changed"),
    ):
        assert finding in str(verify(forge(out, edit), NOTHING))
