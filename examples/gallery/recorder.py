"""Asks a language model's service, and keeps every answer with its time and costs; it keeps no key.

python3 recorder.py answers.jsonl PORT SERVICE MODEL [PRICE_IN PRICE_OUT]

It listens on PORT, runs outside the walls, and sends prompts to SERVICE, an address ending in /chat/completions, with
the key that comes with each prompt. Prices are of a million tokens. It asks for no answer that is in the file.
"""

import json
import sys
import time
import urllib.request
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

file, port, service, model = sys.argv[1:5]
price_in, price_out = map(float, sys.argv[5:7] or (0, 0))
Path(file).touch()
lines = Path(file).read_text(encoding="utf-8").splitlines()
known = {answer["prompt"]: answer for answer in map(json.loads, lines)}


def ask(prompt: str, key: str) -> dict:
    """Return the service's answer to a prompt."""
    question = {"model": model, "temperature": 0, "messages": [{"role": "user", "content": prompt}]}
    headers = {"Authorization": key, "Content-Type": "application/json"}
    begin = time.monotonic()
    with urllib.request.urlopen(
        urllib.request.Request(service, json.dumps(question).encode(), headers)
    ) as reply:
        document = json.load(reply)
    tokens_in, tokens_out = (document["usage"][f"{name}_tokens"] for name in ("prompt", "completion"))
    return {
        "prompt": prompt,
        "text": document["choices"][0]["message"]["content"],
        "seconds": round(time.monotonic() - begin, 3),
        "model": document["model"],
        "tokens_in": tokens_in,
        "tokens_out": tokens_out,
        "price": round((tokens_in * price_in + tokens_out * price_out) / 1e6, 9),
    }


class Recorder(BaseHTTPRequestHandler):
    """Answers each prompt that is posted with a JSON object, and keeps it in a line of the file."""

    def do_POST(self) -> None:
        """Ask the service, unless the answer is known."""
        prompt = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        if prompt not in known:
            known[prompt] = ask(prompt, self.headers["Authorization"])
            with Path(file).open("a", encoding="utf-8") as answers:
                answers.write(json.dumps(known[prompt]) + "\n")
        self.send_response(200)
        self.end_headers()
        self.wfile.write(json.dumps(known[prompt]).encode())


HTTPServer(("localhost", int(port)), Recorder).serve_forever()
