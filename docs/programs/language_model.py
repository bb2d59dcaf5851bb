"""A language model as a managing system; answers that were recorded take its place in replays.

python3 language_model.py http://localhost:8000    asks the recorder at this address
python3 language_model.py answers.jsonl            looks answers up
"""

import json
import sys
import urllib.request
from pathlib import Path

MARGIN_S = 1.0  # frequencies are of the last second, so that an adaptation shows no sooner

source = sys.argv[1]
system = json.loads(sys.stdin.readline())["system"]
adaptations = {adaptation["id"]: adaptation for adaptation in system["adaptations"]}
boot_s = {node["name"]: node["activation_delay_s"] for node in system["nodes"]}
limits = {signal["name"]: signal for signal in system["signals"] if "threshold" in signal}

INTRODUCTION = "\n".join(
    [
        "You repair the perception pipeline of a robot. Its nodes, with what each gets, sends, and needs to boot:",
        *(
            f"- {node['name']}: {', '.join(node['inputs'])} -> {', '.join(node['outputs'])};"
            f" {boot_s[node['name']]:g} s after a redeploy"
            for node in system["nodes"]
        ),
        "A topic without messages silences all nodes after it. Signals are ill beyond their thresholds:",
        *(
            f"- {name}: {'below' if signal['below'] else 'above'} {signal['threshold']:g}"
            for name, signal in limits.items()
        ),
        f"Answer with one of: {', '.join(adaptations)}, or nothing.",
    ]
)


def is_ill(symptoms):
    """Return whether there is anything to ask a model about, which takes its time."""
    silent = any(
        value == 0 for name, value in symptoms.items() if name.endswith("_freq") and "heartbeat" not in name
    )
    values = {name: value for name, value in symptoms.items() if name in limits}
    return silent or any(
        (value < limits[name]["threshold"]) == limits[name]["below"] for name, value in values.items()
    )


def ask(prompt):
    """Return what the model answers: a text, and the seconds that it took."""
    if source.startswith("http"):
        with urllib.request.urlopen(source, json.dumps(prompt).encode()) as response:
            return json.load(response)
    with Path(source).open(encoding="utf-8") as file:
        recorded = {one["prompt"]: one for one in map(json.loads, file)}
    if prompt not in recorded:
        sys.exit(f"There is no recorded answer to {prompt!r}: record it first.")
    return recorded[prompt]


history = []  # what was done, and whether it was accepted
next_s = 0.0  # until then, what was done last cannot have shown

for line in sys.stdin:
    decision = json.loads(line)
    now_s, symptoms = decision["time"], decision["symptoms"]
    for result in decision["results"]:
        history[result["id"]] += ", accepted" if result["accepted"] else ", refused"
    if now_s < next_s or not is_ill(symptoms):
        print("{}", flush=True)
        continue
    shown = {name: round(value, 2) if type(value) is float else value for name, value in symptoms.items()}
    done = "; ".join(history) or "nothing"
    answer = ask(f"{INTRODUCTION}\nTime: {now_s:.1f} s. Done: {done}. Symptoms: {json.dumps(shown)}.")
    name, acted_s = answer["text"].strip(), now_s + answer["seconds"]
    next_s = acted_s + MARGIN_S
    chosen = []
    if name in adaptations:
        chosen = [adaptations[name] | {"id": len(history)}]
        history.append(f"{acted_s:.1f} s {name}")
        if adaptations[name]["kind"] == "redeploy":
            next_s += boot_s[adaptations[name]["node"]]
    print(json.dumps({"adaptations": chosen, "think_s": answer["seconds"]}), flush=True)
