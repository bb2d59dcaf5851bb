"""A managing system that inspects images: it compares the input of each node with its output."""

from collections import deque
from functools import partial
from typing import Final, cast

import numpy as np

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Waits, Wiring, request
from sunset.system.vocabulary import (
    REPAIR,
    Adaptation,
    AdaptationKind,
    Fault,
    Value,
    current_system,
    full_name,
    redeploy,
    restart,
)
from sunset.system_interfaces.msg import SensorFusion
from sunset_ros.interfaces.sensor_msgs.msg import Image

_SLOWEST_S: Final = 0.05  # no node takes longer for a frame
_EFFECT_S: Final = 0.3  # three frames, in which an adaptation shows its effect
_BOOTED_S: Final = 0.5  # from the end of a node's boot to its first images, with a margin
_PAUSE_S: Final = 5.0  # after a restart and a redeploy without effect, whose price is 1.4 s of output
_DARK: Final = 0.75  # share of the usual brightness: the scene alone keeps more, and the IoU is a tenth lower
_BRIGHT: Final = 0.85  # dark images are bright again; a single limit would make the enhancement flicker
_BLURRED: Final = 0.25  # share of the usual detail: the scene alone keeps half, a blur of a pixel a tenth
_NOISY_M: Final = 0.2  # above it the colour image alone is segmented better (`sunset models curves lite`)
_QUIET_M: Final = 0.05  # healthy depths are rounded to 0.015 m, which looks like a noise of 0.01 m
_STRENGTH_ERROR: Final = 0.2  # costs some hundredths of the IoU, more than the price of setting it
_MEMORY: Final = 100  # frames in a mean: fewer would follow a growing fault, more would lag behind the scene

_MODALITY: Final = ("sensor_fusion", "modality")
_SOURCE: Final = ("sensor_fusion", "topic_camera_input")
_STRENGTH: Final = ("image_enhancement", "image_degradation")


class Inspecting(ManagingSystem):
    """Inspects the images between the nodes, and cures the faults that they show.

    Each fault has a sign:

    - *Outage*: two images came into a node and none came out. A managing system must not read the inputs of the camera
      and the depth node, so it compares their outputs with each other. An image that repeats the last does not count.
      It restarts the node, and redeploys it if that does not help. While a sensor boots, the fusion takes the other.
    - *Misaligned images*: the fusion's colour image equals neither the camera's nor the enhanced image.
    - *Unneeded enhancement*: the fusion takes the enhanced image without being set to.
    - *Dark images*: the camera's brightness has fallen. The enhancement gets the strength that fits.
    - *Blurred images*: the camera's neighbouring pixels hardly differ.
    - *Noisy depth*: the depth image's neighbouring pixels differ at random. The fusion does without the depth image.

    It lifts a workaround when the sensor's own images are good again.
    """

    def on_start(self) -> None:
        """Subscribe to the images."""
        self.waits, self.faults, self.boot_s = Waits(self), current_system().faults, Wiring().boot_s
        images = ("rgb_camera", "depth_camera", "rgb_enhanced", "segmentation")
        self.images = {topic: deque[Image](maxlen=10) for topic in images}
        self.came_s = {topic: deque([0.0, 0.0], maxlen=2) for topic in (*images, "sensors_fused")}
        self.usual = {measure: deque[float](maxlen=_MEMORY) for measure in ("brightness", "detail")}
        self.is_dark = self.is_blurred = self.is_altered = False
        self.strength = self.noise_m = 0.0
        self.healthy: dict[tuple[str, str], Value] = {_MODALITY: 0, _SOURCE: "rgb_camera"}
        self.healthy[_STRENGTH] = self.faults["image_degradation"].value
        self.wanted, self.seen = dict(self.healthy), dict(self.healthy)
        self.tried: dict[str, list[tuple[Adaptation, ...]]] = {}  # sign → cures
        self.booting: set[str] = set()
        self.may_adapt = self.greeting["task"] == REPAIR
        for topic in images:
            self.create_subscription(Image, full_name(topic), partial(self.on_image, topic), 10)
        self.create_subscription(SensorFusion, full_name("sensors_fused"), self.on_fused, 10)

    def on_image(self, topic: str, image: Image) -> None:
        """Note when a new image came, and measure it if it is a sensor's."""
        kept = self.images[topic]
        repeats = bool(kept) and topic != "segmentation" and np.array_equal(kept[-1].data, image.data)
        kept.append(image)
        if not repeats:
            self.came_s[topic].append(self.now_s)
        if topic == "rgb_camera":
            rows = image.data.reshape(image.height, -1, 3)[::4].astype(np.float32)
            limit = _BRIGHT if self.is_dark else _DARK
            share = self.share("brightness", float(rows.mean()), limit)
            self.is_dark = share < limit
            self.strength = min(2.0 * (1.0 - share), 1.9)  # a strength of 1 takes half of the brightness
            detail = float(np.diff(rows, 2, axis=1).var() / max(float(rows.var()), 1.0))
            self.is_blurred = self.share("detail", detail, _BLURRED) < _BLURRED
        elif topic == "depth_camera":
            metres = image.data.view("<u2").reshape(image.height, -1)[::8] / np.float32(65.535)
            bend = float(np.median(np.abs(np.diff(metres, 2))))  # a median ignores edges
            self.noise_m = bend / 0.6745 / 6**0.5  # a normal distribution's median; 1² + 2² + 1²

    def share(self, measure: str, value: float, limit: float) -> float:
        """Return a value as a share of its usual mean, and include it there unless the share is under a limit."""
        usual = self.usual[measure]
        share = value / float(np.mean(usual)) if usual else 1.0
        if share >= limit:
            usual.append(value)
        return share

    def on_fused(self, fused: SensorFusion) -> None:
        """Note which colour images the fusion takes, and whether it changes them."""
        self.came_s["sensors_fused"].append(self.now_s)
        same = {
            topic: np.array_equal(image.data, fused.rgb.data)
            for topic in ("rgb_camera", "rgb_enhanced")
            for image in self.images[topic]
            if image.header.stamp == fused.rgb.header.stamp
        }
        self.is_altered = bool(same) and not any(same.values())
        if self.waits.over("settings"):
            self.seen[_MODALITY] = int(fused.modality.fusion_type)
            self.seen[_SOURCE] = next((topic for topic in same if same[topic]), self.seen[_SOURCE])

    def adapt(self, symptoms: Symptoms) -> None:
        """Publish a diagnosis, cure the faults inside nodes, and work around the others."""
        signs = self.signs()
        self.tried = {sign: cures for sign, cures in self.tried.items() if sign in signs}
        self.say(signs)
        if self.may_adapt:
            for sign, node in signs.items():
                if self.waits.over(node):
                    self.cure(sign, node)
            self.settle(signs, symptoms)

    def signs(self) -> dict[str, str]:
        """Return the signs of faults inside nodes, sign → node: an outage's sign is the node, another's the fault."""
        source = str(self.seen[_SOURCE])
        inputs = ([source, "depth_camera"], [source], ["depth_camera"])[int(self.seen[_MODALITY])]
        given_and_sent = {
            "camera": (["depth_camera"], "rgb_camera"),
            "depth": (["rgb_camera"], "depth_camera"),
            "sensor_fusion": (inputs, "sensors_fused"),
            "segmentation": (["sensors_fused"], "segmentation"),
        }
        if source == "rgb_enhanced":
            given_and_sent["image_enhancement"] = (["rgb_camera"], source)
        signs = {}
        for node, (given, sent) in given_and_sent.items():
            last_s = self.came_s[sent][-1]
            if last_s and all(self.came_s[topic][0] > last_s + _SLOWEST_S for topic in given):
                signs[node] = node  # two frames came in and none out
        if self.is_blurred and "camera" not in signs:
            signs["autofocus_needed"] = "camera"
        if self.is_altered and "sensor_fusion" not in signs:
            signs["image_shift"] = "sensor_fusion"
        return signs

    def suspects(self, sign: str) -> list[Fault]:
        """Return the faults that may cause a sign, except faults that the tried cures would have ended."""
        tried, failures = set(self.tried.get(sign, [])), current_system().failures
        return [
            fault
            for fault in self.faults.values()
            if (fault.name == sign or (fault.node == sign and failures[fault.failure].topic))
            and not tried.intersection(fault.cures)
        ]

    def say(self, signs: dict[str, str]) -> None:
        """Publish a diagnosis."""
        probabilities = {
            "image_degradation": float(self.is_dark),
            "depth_degradation": float(self.noise_m > _QUIET_M),
            "unneeded_enhancement": float(self.seen[_SOURCE] == "rgb_enhanced" != self.wanted[_SOURCE]),
        }
        for suspects in map(self.suspects, signs):
            probabilities |= {fault.name: 1.0 / len(suspects) for fault in suspects}
        self.diagnose(probabilities)

    def cure(self, sign: str, node: str) -> None:
        """Try the next cure: first the suspects' cures, then a restart and a redeploy, as the fault may be unlisted.

        After the last it gives up; for a node that sends nothing, it tries all of them again after a pause.
        """
        tried = self.tried.setdefault(sign, [])
        listed = [cure for fault in self.suspects(sign) for cure in fault.cures]
        unlisted = [(restart(node),), (redeploy(node),)]
        left = [cure for cure in [*listed, *unlisted] if cure not in tried]
        if not left and sign == node:
            tried.clear()
            self.waits.start(node, _PAUSE_S)
        for step in left[0] if left else ():
            is_redeploy = step.kind is AdaptationKind.REDEPLOY
            request(self, step)
            self.waits.start(node, self.boot_s[node] + _BOOTED_S if is_redeploy else _EFFECT_S)
            if is_redeploy:
                self.seen |= {key: value for key, value in self.healthy.items() if key[0] == node}
                self.booting.add(node)
        tried += left[:1]

    def settle(self, signs: dict[str, str], symptoms: Symptoms) -> None:
        """Set the necessary workarounds, and lift the others."""
        self.booting &= signs.keys()
        if "camera" in self.booting:
            self.wanted[_MODALITY] = 2
        elif "camera" not in signs:
            self.wanted[_MODALITY] = 1 if "depth" in self.booting or self.noise_m > _NOISY_M else 0
        self.wanted[_SOURCE] = "rgb_enhanced" if self.is_dark else "rgb_camera"
        if self.is_dark and abs(self.strength - cast("float", self.wanted[_STRENGTH])) > _STRENGTH_ERROR:
            self.wanted[_STRENGTH] = round(self.strength, 1)
        if self.is_dark and symptoms.state(_STRENGTH[0]) != "active" and self.waits.over("activation"):
            self.activate(_STRENGTH[0])
            self.waits.start("activation", _BOOTED_S)
        for (node, parameter), value in self.wanted.items():
            is_up = self.waits.over(node) or symptoms.state(node) == "inactive"
            if self.seen[node, parameter] != value and is_up:
                self.set_parameter(node, parameter, value)
                self.seen[node, parameter] = value
                self.waits.start("settings", _EFFECT_S)
