"""A language model: it chooses among the cures of a failure; recorded answers take its place in replays."""

import json
import os
import re
import urllib.request
from pathlib import Path

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment
from sunset.system.vocabulary import Failure


class LanguageModel(ManagingSystem):
    """Asks `recorder.py` at the address LANGUAGE_MODEL_URL, with LANGUAGE_MODEL_KEY; else looks its answers up."""

    files = ("answers.jsonl",)

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.url = os.environ.get("LANGUAGE_MODEL_URL", "")
        lines = (Path(__file__).parent / self.files[0]).read_text(encoding="utf-8").splitlines()
        self.recorded = {answer["prompt"]: answer for answer in map(json.loads, lines)}

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        if failure is None:
            return
        untried = self.treatment.untried(failure)
        answer = self.ask(self.prompt(failure, untried))
        self.spend(**{name: answer[name] for name in ("model", "tokens_in", "tokens_out", "price")})
        self.think(answer["seconds"])
        number = re.search(r"\d+", answer["text"])
        chosen = int(number.group()) if number else 0
        option = untried[chosen - 1] if 0 < chosen <= len(untried) else untried[0]
        self.treatment.try_cure(failure, option, think_s=answer["seconds"])

    def prompt(self, failure: Failure, untried: tuple[Option, ...]) -> str:
        """Return the question, which is the same whenever the same cures are left."""
        cures = [
            f"{number}. {option} ({option.seconds:g} s; cures {', '.join(option.faults) or 'unknown faults'})"
            for number, option in enumerate(untried, 1)
        ]
        return "\n".join(
            [
                f"In a robot's software, {failure.description}. Which cure do you try?",
                *cures,
                "Only the number.",
            ]
        )

    def ask(self, prompt: str) -> dict:
        """Return an answer: a text, the seconds that it took, and its costs."""
        if self.url:
            key = {"Authorization": f"Bearer {os.environ['LANGUAGE_MODEL_KEY']}"}
            request = urllib.request.Request(self.url, json.dumps(prompt).encode(), key)
            with urllib.request.urlopen(request) as response:
                return json.load(response)
        if prompt not in self.recorded:
            raise LookupError(f"There is no recorded answer to {prompt!r}: record it first")
        return self.recorded[prompt]
