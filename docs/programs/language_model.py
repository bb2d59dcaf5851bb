"""A language model as a managing system; answers that were recorded take its place in replays.

python3 language_model.py http://localhost:8000    asks the recorder at this address
python3 language_model.py answers.jsonl            looks answers up
"""

import json
import sys
import urllib.request
from pathlib import Path

source = sys.argv[1]
system = json.loads(sys.stdin.readline())["system"]
adaptations = {adaptation["id"]: adaptation for adaptation in system["adaptations"]}
limits = {signal["name"]: signal for signal in system["signals"]}


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


for line in sys.stdin:
    decision = json.loads(line)
    if not is_ill(decision["symptoms"]):
        print("{}", flush=True)
        continue
    shown = {
        name: round(value, 2) if type(value) is float else value
        for name, value in decision["symptoms"].items()
    }
    answer = ask(f"Symptoms: {json.dumps(shown)}. Answer with one of: {', '.join(adaptations)}, or nothing.")
    chosen = [adaptations[name] for name in [answer["text"].strip()] if name in adaptations]
    print(json.dumps({"adaptations": chosen, "think_s": answer["seconds"]}), flush=True)
