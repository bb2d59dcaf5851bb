"""Faults that no catalogue lists, with their cures; `suite.yaml` has their onsets.

Confined processes cannot read this folder, so a managing system knows only its own conclusions about these faults.
Their strengths are chosen from the output of `scripts/measure_wild`: the symptom's signal is clearly beyond its
threshold, and the IoU lower by a quarter or more, on the default flight with the model `lite`.
"""

from pathlib import Path
from typing import Final

from sunset.files.inputs import read_text
from sunset.system import (
    MODALITIES,
    USE_CAMERA,
    Adaptation,
    Extension,
    Fault,
    FaultKind,
    redeploy,
    restart,
)


def _either(node: str) -> tuple[tuple[Adaptation, ...], ...]:
    return (restart(node),), (redeploy(node),)


_FAULTS: Final = (
    Fault(
        name="frozen_image",
        failure="F4",
        node="camera",
        cures=_either("camera"),
        description="The camera repeats its last image under new stamps.",
    ),
    Fault(
        name="overexposure",
        failure="F4",
        node="camera",
        value=0.75,
        limits=(0.0, 20.0),
        cures=((redeploy("camera"),),),
        description="The camera's exposure control is off until the hardware restarts: its images are too bright.",
    ),
    Fault(
        name="cold_light",
        failure="F4",
        node="camera",
        value=0.3,
        limits=(0.0, 1.0),
        kind=FaultKind.EXTERNAL,
        cures=((MODALITIES[2],),),
        description="The light is so blue that the networks of colour images fail; that of depth images does not.",
    ),
    Fault(
        name="lens_film",
        failure="F5",
        node="camera",
        value=0.85,
        limits=(0.0, 1.0),
        cures=_either("camera"),
        description="A film on the camera's lens scatters the light, until the camera's start shakes it off.",
    ),
    Fault(
        name="scale_error",
        failure="F4",
        node="depth",
        value=2.0,
        limits=(0.0, 10.0),
        cures=((redeploy("depth"),),),
        description="The depth camera's scale is off until the hardware restarts: all is too far away.",
    ),
    Fault(
        name="lossy_link",
        failure="F2",
        node="depth",
        cures=_either("depth"),
        description="Of twenty depth images, one arrives.",
    ),
    Fault(
        name="stepped_clock",
        failure="F2",
        node="depth",
        value=0.25,
        limits=(0.0, 60.0),
        cures=((redeploy("depth"),),),
        description="The depth camera's clock has stepped until a new process sets it: no stamp fits a colour image's.",
    ),
    Fault(
        name="short_buffer",
        failure="F3",
        node="sensor_fusion",
        cures=_either("sensor_fusion"),
        description="The fusion sends half of each image only, which the segmentation drops.",
    ),
    Fault(
        name="hot_processor",
        failure="F3",
        node="segmentation",
        kind=FaultKind.EXTERNAL,
        cures=((MODALITIES[1],), (MODALITIES[2],)),
        description="It is hot, and the network of both images takes 2.5 s a frame; those of one image do not.",
    ),
    Fault(
        name="upside_down",
        failure="F4",
        node="camera",
        cures=((redeploy("camera"),),),
        description="The camera has forgotten how it is mounted, and turns its images by half.",
    ),
    Fault(
        name="idle_input",
        failure="F2",
        node="sensor_fusion",
        parameter="topic_camera_input",
        value="rgb_enhanced",
        healthy="rgb_camera",
        kind=FaultKind.CONFIGURATION,
        cures=((USE_CAMERA,),),
        description="The fusion was left on the enhanced images, without a publisher.",
    ),
)

SEALED: Final = ("upside_down", "idle_input")
"""Faults without a suite: only a split with a salt draws them."""

UNLISTED: Final = Extension(
    faults=_FAULTS,
    exclusive=(("idle_input", "image_degradation"), ("idle_input", "unneeded_enhancement")),
    suites={"wild": read_text(Path(__file__).with_name("suite.yaml"))},
)
