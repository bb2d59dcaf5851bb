"""The paper's managed system: a drone's perception pipeline, its eleven faults, and their cures."""

from itertools import combinations, product
from pathlib import Path
from types import MappingProxyType
from typing import Final

from sunset.files.inputs import read_text
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Effect,
    Failure,
    Fault,
    FaultKind,
    NodeDescription,
    Signal,
    Topic,
    View,
    redeploy,
    restart,
)
from sunset.system.system import Extension

IMAGE_DEGRADATION_RANGE: Final = (0.0, 1.9)
"""Least and greatest strength of the images' degradation; at 2 the image would be black."""

DEPTH_DEGRADATION_RANGE: Final = (0.0, 100.0)
"""Least and greatest standard deviation of the depth's noise, in metres."""

BLUR_SIGMA: Final = 2.0
"""Standard deviation in pixels of an unfocused camera's blur, on an image 256 wide."""

ENTROPY_SIGNAL: Final = Signal("segmentation", "entropy", calibrated=True)
"""The uncertainty of the segmentation."""

SHARPNESS_SIGNAL: Final = Signal("camera", "sharpness", below=True, calibrated=True)
"""The sharpness of the camera's images."""

_NODES: Final = (
    NodeDescription("camera", "sunset.nodes:Camera", ("/rgb_raw",), ("rgb_camera",), 4.0, 0.002),
    NodeDescription("depth", "sunset.nodes:Depth", ("/depth_raw",), ("depth_camera",), 4.0, 0.002),
    NodeDescription(
        "image_enhancement", "sunset.nodes:ImageEnhancement", ("rgb_camera",), ("rgb_enhanced",), -1.0, 0.003
    ),
    NodeDescription(
        "sensor_fusion", "sunset.nodes:Fusion", ("rgb_camera", "depth_camera"), ("sensors_fused",), 2.0, 0.003
    ),
    NodeDescription(
        "segmentation", "sunset.nodes:SegmentationNode", ("sensors_fused",), ("segmentation",), 2.0, 0.040
    ),
)

_TOPICS: Final = (
    *map(Topic, ("/rgb_raw", "/depth_raw", "rgb_camera", "depth_camera", "rgb_enhanced")),
    Topic("sensors_fused", "system_interfaces/msg/SensorFusion"),
    Topic("segmentation"),
)

_FAILURES: Final = (
    Failure(
        "F1",
        "the camera sends no images",
        symptom="no camera image for 1 s",
        gone="camera images are back",
        topic="rgb_camera",
    ),
    Failure(
        "F2",
        "the sensor fusion sends no images",
        symptom="no fused image for 1 s",
        gone="fused images are back",
        topic="sensors_fused",
    ),
    Failure(
        "F3",
        "the segmentation sends no results",
        symptom="no segmentation for 1 s",
        gone="segmentation is back",
        topic="segmentation",
    ),
    Failure(
        "F4",
        "the segmentation is unsure of its results",
        symptom="segmentation unsure: entropy over its threshold",
        gone="segmentation is sure again",
        signal=ENTROPY_SIGNAL.name,
    ),
    Failure(
        "F5",
        "the camera's images are blurred",
        symptom="camera image blurred: sharpness under its threshold",
        gone="camera images are sharp again",
        signal=SHARPNESS_SIGNAL.name,
    ),
)


_ACTIVATE_ENHANCEMENT = Adaptation(AdaptationKind.ACTIVATE, "image_enhancement")
_DEACTIVATE_ENHANCEMENT = Adaptation(AdaptationKind.DEACTIVATE, "image_enhancement")
USE_CAMERA: Final = Adaptation(
    AdaptationKind.CHANGE_TOPIC, "sensor_fusion", "topic_camera_input", "rgb_camera"
)
"""The fusion takes the camera's images again."""
_USE_ENHANCED = Adaptation(AdaptationKind.CHANGE_TOPIC, "sensor_fusion", "topic_camera_input", "rgb_enhanced")
MODALITIES: Final = tuple(
    Adaptation(AdaptationKind.SET_PARAMETER, "sensor_fusion", "modality", value) for value in (0, 1, 2)
)
"""The fusion passes on both images, the camera's alone, the depth camera's alone."""
_VIEWS: Final = (
    View(MODALITIES[0], frozenset({"camera", "depth"})),
    # with the colour image alone, the entropy stays calm where that image is dark or misaligned
    View(MODALITIES[1], frozenset({"camera"}), is_conclusive=False),
    View(MODALITIES[2], frozenset({"depth"})),
)
_RECALIBRATE = Adaptation(AdaptationKind.SET_PARAMETER, "sensor_fusion", "do_recalibration", value=True)
_AUTOFOCUS = Adaptation(AdaptationKind.SET_PARAMETER, "camera", "perform_autofocus", value=True)

_IMAGE_DEGRADATIONS: Final = (0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5)

_PRICES: Final = MappingProxyType(
    {
        **dict.fromkeys(AdaptationKind, 2.0),
        AdaptationKind.RESTART: 4.0,
        AdaptationKind.REDEPLOY: 10.0,
    }
)
"""In frames, of which the paper's flight has ten a second: the output that an adaptation costs a healthy system."""

_FAULTS: Final = (
    Fault(
        name="camera_driver_issue",
        failure="F1",
        node="camera",
        cures=((restart("camera"),), (redeploy("camera"),)),
        description="The camera's driver hangs and sends no images until it is restarted.",
    ),
    Fault(
        name="hardware_disconnect",
        failure="F1",
        node="camera",
        cures=((redeploy("camera"),),),
        description="The camera has lost its connection, and only a redeploy reconnects it.",
    ),
    Fault(
        name="sync_issue",
        failure="F2",
        node="sensor_fusion",
        cures=((restart("sensor_fusion"),), (redeploy("sensor_fusion"),)),
        description="The fusion finds no matching pairs of images until it is restarted.",
    ),
    Fault(
        name="memory_leakage",
        failure="F2",
        node="sensor_fusion",
        cures=((redeploy("sensor_fusion"),),),
        description="The fusion has used up its memory, and only a new process releases it.",
    ),
    Fault(
        name="cuda_out_of_memory",
        failure="F3",
        node="segmentation",
        cures=((restart("segmentation"),), (redeploy("segmentation"),)),
        description="The segmentation gets no memory on the graphics card until it is restarted.",
    ),
    Fault(
        name="gpu_failure",
        failure="F3",
        node="segmentation",
        cures=((redeploy("segmentation"),),),
        description="The graphics card has failed, and only a redeploy resets it.",
    ),
    Fault(
        name="image_degradation",
        failure="F4",
        node="camera",
        value=0.9,
        kind=FaultKind.EXTERNAL,
        cures=((_ACTIVATE_ENHANCEMENT, _USE_ENHANCED),),
        limits=IMAGE_DEGRADATION_RANGE,
        effect=Effect(
            degrade="sunset.faults:degrade_image",
            restore="sunset.faults:enhance_image",
            strengths=_IMAGE_DEGRADATIONS,
        ),
        description="The camera's images are darker and their colours are shifted.",
    ),
    Fault(
        name="unneeded_enhancement",
        failure="F4",
        node="sensor_fusion",
        parameter="topic_camera_input",
        value="rgb_enhanced",
        healthy="rgb_camera",
        kind=FaultKind.CONFIGURATION,
        cures=((USE_CAMERA,),),
        injection=(_ACTIVATE_ENHANCEMENT, _USE_ENHANCED),
        effect=Effect(
            degrade="sunset.faults:enhance_image", strengths=_IMAGE_DEGRADATIONS, suite="image_degradation"
        ),
        description="The image enhancement is applied to images that are good without it.",
    ),
    Fault(
        name="image_shift",
        failure="F4",
        node="sensor_fusion",
        value=10,
        cures=((_RECALIBRATE,), (redeploy("sensor_fusion"),)),
        limits=(0, 1920),
        effect=Effect(
            degrade="sunset.faults:misalign_image",
            strengths=(1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 40),
            unit="pixels of 256",
        ),
        description="The fusion has lost its calibration: colour and depth images no longer match.",
    ),
    Fault(
        name="depth_degradation",
        failure="F4",
        node="depth",
        value=0.25,
        kind=FaultKind.EXTERNAL,
        cures=((MODALITIES[1],),),
        limits=DEPTH_DEGRADATION_RANGE,
        effect=Effect(
            degrade="sunset.faults:degrade_depth",
            sensor="depth",
            random=True,
            strengths=(0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0),
            unit="noise [m]",
        ),
        description="The depth images are noisy; the strength is the noise's standard deviation in metres.",
    ),
    Fault(
        name="autofocus_needed",
        failure="F5",
        node="camera",
        cures=((_AUTOFOCUS,), (redeploy("camera"),)),
        effect=Effect(
            degrade="sunset.faults:defocus_image",
            strengths=(0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0),
            suite=BLUR_SIGMA,
            unit="blur [pixels of 256]",
        ),
        description="The camera has lost its focus and its images are blurred.",
    ),
)

_EXCLUSIVE: Final = (("image_degradation", "unneeded_enhancement"),)

# by name, so that the paper's suites stay the same when a fault is added
_OUTAGES: Final = (
    "camera_driver_issue",
    "hardware_disconnect",
    "sync_issue",
    "memory_leakage",
    "cuda_out_of_memory",
    "gpu_failure",
)
_OUTAGES_OF_NODES: Final = (_OUTAGES[:2], _OUTAGES[2:4], _OUTAGES[4:])
_DEGRADATIONS: Final = (
    "image_degradation",
    "unneeded_enhancement",
    "image_shift",
    "depth_degradation",
    "autofocus_needed",
)
_PAIRS: Final = tuple(pair for pair in combinations(_DEGRADATIONS, 2) if pair not in _EXCLUSIVE)

PAPER: Final = Extension(
    nodes=_NODES,
    topics=_TOPICS,
    signals=(ENTROPY_SIGNAL, SHARPNESS_SIGNAL),
    failures=_FAILURES,
    faults=_FAULTS,
    prices=_PRICES,
    adaptations=(
        _ACTIVATE_ENHANCEMENT,
        _DEACTIVATE_ENHANCEMENT,
        USE_CAMERA,
        _USE_ENHANCED,
        *MODALITIES,
        _RECALIBRATE,
        _AUTOFOCUS,
    ),
    exclusive=_EXCLUSIVE,
    views=_VIEWS,
    suites={
        # every outage with every two of the other faults that can be there together (paper, section 4)
        "paper": tuple((outage, *pair) for outage in _OUTAGES for pair in _PAIRS),
        # every outage with one degradation and a blurred image, as in the published exemplar's files
        "artifact": tuple(
            (outage, degradation, "autofocus_needed")
            for outage in _OUTAGES
            for degradation in ("image_degradation", "depth_degradation", "image_shift")
        ),
        # a healthy run: the first row of the paper's table
        "nofault": ((),),
        # the pairs of the paper's suite without an outage: the table's second row
        "degraded": _PAIRS,
        "single": tuple((fault.name,) for fault in _FAULTS),
        # every two and every three outages of different nodes
        "outages": tuple(
            outages
            for count in (2, 3)
            for nodes in combinations(_OUTAGES_OF_NODES, count)
            for outages in product(*nodes)
        ),
        **{
            name: read_text(Path(__file__).parent / "suite_files" / f"{name}.yaml")
            for name in ("timed", "transient", "cascade", "calm", "long")
        },
    },
)
