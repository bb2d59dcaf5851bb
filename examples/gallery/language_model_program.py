"""A language model, as a program: it sees symptoms and the offered adaptations, and names an adaptation.

python3 language_model_program.py http://localhost:8000    asks recorder.py there, with LANGUAGE_MODEL_KEY
python3 language_model_program.py answers.jsonl            looks its answers up
"""

import json
import os
import sys
import urllib.request
from pathlib import Path

source = sys.argv[1]
system = json.loads(sys.stdin.readline())["system"]
offered = {adaptation["id"]: adaptation for adaptation in system["adaptations"]}
nodes = {node["name"]: node for node in system["nodes"]}
topics = [topic for node in nodes.values() if node["state"] == "active" for topic in node["outputs"]]


def symptom_of(symptoms):
    """Return the symptom furthest upstream in words; an empty text if all is well."""
    for topic in topics:
        if symptoms.get(f"managed_subsystem_{topic}_freq") == 0:
            return f"the topic {topic} has no messages"
    for signal in system["signals"]:
        value, threshold = symptoms.get(signal["name"]), signal.get("threshold")
        if None not in {value, threshold} and (value < threshold if signal["below"] else value > threshold):
            return f"the signal {signal['name']} is too {'low' if signal['below'] else 'high'}"
    return ""


def ask(prompt):
    """Return an answer: a text, the seconds that it took, and its costs."""
    if source.startswith("http"):
        key = {"Authorization": f"Bearer {os.environ['LANGUAGE_MODEL_KEY']}"}
        with urllib.request.urlopen(
            urllib.request.Request(source, json.dumps(prompt).encode(), key)
        ) as reply:
            return json.load(reply)
    lines = Path(source).read_text(encoding="utf-8").splitlines()
    recorded = {answer["prompt"]: answer for answer in map(json.loads, lines)}
    return recorded.get(prompt) or sys.exit(f"There is no recorded answer to {prompt!r}: record it first.")


last, next_s = "nothing", 0.0  # the last adaptation, and when its effect can be seen
for line in sys.stdin:
    decision = json.loads(line)
    symptom = symptom_of(decision["symptoms"])
    if not symptom or decision["time"] < next_s:
        print("{}", flush=True)
        continue
    lines = [f"In a robot's software, {symptom}. The last adaptation: {last}. Which do you try?", *offered]
    answer = ask("\n".join([*lines, "Only the line."]))
    named = [name for name in offered if name in answer["text"]]
    adaptations = [offered[named[0]]] if named else []
    last = named[0] if named else last
    boots = [nodes[each["node"]]["activation_delay_s"] for each in adaptations if each["kind"] == "redeploy"]
    next_s = decision["time"] + answer["seconds"] + 1.0 + sum(boots)
    cost = {name: answer[name] for name in ("model", "tokens_in", "tokens_out", "price")}
    print(json.dumps({"adaptations": adaptations, "think_s": answer["seconds"], "cost": cost}), flush=True)
