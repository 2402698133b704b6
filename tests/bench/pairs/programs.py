"""Runs a program of the bench, and says why it failed."""
import hashlib
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess

KEPT_LINES = 12  # of what a failed run wrote


class Failed(Exception):
    """A run failed, or its answers are wrong."""


def why(status, errors):
    lines = errors.strip().splitlines()
    text = "\n".join(lines[-KEPT_LINES:])
    if status < 0:
        text = f"{text}\nended by {signal.Signals(-status).name}".strip()
    return text or f"exit status {status}, without a message"


class Program:
    """One sightline-bench. `seconds` is the longest time that a run may take."""

    def __init__(self, path, seconds):
        self.path, self.seconds = pathlib.Path(path).resolve(), seconds
        self.verbs = self.read_verbs()

    def output(self, words):
        """What a run prints. Its children, such as a server, end with it."""
        run = subprocess.Popen([self.path, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        try:
            text, errors = run.communicate(timeout=self.seconds)
        except subprocess.TimeoutExpired:
            raise Failed(f"{self.command(words)}\nno end within {self.seconds:g} s") from None
        finally:
            if run.poll() is None:
                os.killpg(run.pid, signal.SIGKILL)
                run.communicate()
        if run.returncode != 0:
            raise Failed(f"{self.command(words)}\n{why(run.returncode, errors)}")
        return text

    def rows(self, words):
        text = self.output([*words, "--json"])
        try:
            return [json.loads(line) for line in text.splitlines()]
        except json.JSONDecodeError as error:
            raise Failed(f"{self.command(words)}\nits output is no JSON: {error}") from None

    def command(self, words):
        return shlex.join([str(self.path), *words])

    def read_verbs(self):
        try:
            help_text = self.output(["--help"])
        except OSError as error:
            raise Failed(f"{self.path}: {error.strerror}") from None
        _, _, listed = help_text.partition("Subcommands:")
        return {line.split()[0] for line in listed.splitlines() if line.startswith("  ") and line.strip()}

    def names(self, verb, builder):
        """Whether the help of the verb names this builder or peer."""
        return re.search(rf"(?<![\w-]){re.escape(builder)}(?![\w-])", self.output([verb, "--help"])) is not None

    def describe(self):
        """What tells this program from others."""
        return {"path": str(self.path), "sha256": hashlib.sha256(self.path.read_bytes()).hexdigest()}
