"""The paper's baseline, as a program of its own: it redeploys what is silent, and recalibrates what is unsure."""

import json
import sys

system = json.loads(sys.stdin.readline())["system"]
node_of = {topic: node["name"] for node in system["nodes"] for topic in node["outputs"]}
watched = {topic: node_of[topic] for topic in ("rgb_camera", "depth_camera", "sensors_fused", "segmentation")}
(threshold,) = (
    signal["threshold"] for signal in system["signals"] if signal["name"] == "segmentation_entropy"
)
answered = set()

for line in sys.stdin:
    symptoms = json.loads(line)["symptoms"]
    present = [topic for topic in watched if symptoms.get(f"managed_subsystem_{topic}_freq") == 0]
    if symptoms.get("segmentation_entropy", 0) > threshold:
        present.append("entropy")
    adaptations = []
    for symptom in present:
        if symptom in answered:
            continue
        if symptom == "entropy":
            adaptation = {
                "kind": "set_parameter",
                "node": "sensor_fusion",
                "name": "do_recalibration",
                "value": True,
            }
        else:
            adaptation = {"kind": "redeploy", "node": watched[symptom]}
        adaptations.append(adaptation)
    answered = set(present)
    print(json.dumps({"adaptations": adaptations}), flush=True)
