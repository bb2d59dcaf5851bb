"""Asks a model, and keeps every answer with the time that it took.

python3 recorder.py answers.jsonl 8000 COMMAND    the command reads a prompt and prints an answer
"""

import json
import subprocess
import sys
import time
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

file, port, *command = sys.argv[1:]
known = {}


class Recorder(BaseHTTPRequestHandler):
    """Answers each prompt that is posted with a JSON object, and keeps it in a line of the file."""

    def do_POST(self):
        """Ask the model."""
        prompt = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        if prompt not in known:  # the same prompt has the same answer, as in a replay
            begin = time.monotonic()
            text = subprocess.run(command, input=prompt, capture_output=True, text=True, check=True).stdout
            known[prompt] = {"prompt": prompt, "text": text, "seconds": round(time.monotonic() - begin, 3)}
            with Path(file).open("a", encoding="utf-8") as answers:
                answers.write(json.dumps(known[prompt]) + "\n")
        self.send_response(200)
        self.end_headers()
        self.wfile.write(json.dumps(known[prompt]).encode())


HTTPServer(("localhost", int(port)), Recorder).serve_forever()
