"""Runs sightline-bench, and notes each command for the provenance."""
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
SUFFIXES = {"sponza": ".glb", "torcs_forza": ".glb", "japanese_maple": ".glb", "horse_gallop": ""}


class Failed(Exception):
    """A run of sightline-bench failed, or its answers are wrong."""


def run_text(*command):
    """The output of a command, or "" if it failed."""
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    return done.stdout.strip() if done.returncode == 0 else ""


def commit():
    """The short commit of the checkout, with a + if product or bench sources have changes."""
    changed = run_text("git", "status", "--porcelain", "--untracked-files=no", "--", "accel", "scenegraph", "tests/bench", "tests/support")
    return run_text("git", "rev-parse", "--short", "HEAD") + ("+" if changed else "")


def machine():
    with open("/proc/cpuinfo") as file:
        models = [line.split(":")[1].strip() for line in file if line.startswith("model name")]
    return f"{len(models)} cores of {models[0] if models else 'an unknown processor'}"


class Bench:
    """One sightline-bench. `commands` and `seconds` are those since `start` was called."""

    def __init__(self, program, scenes):
        self.program, self.scenes = str(program), pathlib.Path(scenes)
        self.start()

    def start(self):
        self.commands, self.seconds, self.load = [], 0, os.getloadavg()[0]

    def resolve(self, word):
        """Replaces {NAME} in a word by the path of the scene file NAME."""
        for name in {part.split("}")[0] for part in word.split("{")[1:]}:
            word = word.replace(f"{{{name}}}", str(self.scenes / (name + SUFFIXES.get(name, ".ply"))))
        return word

    def run(self, *words):
        """Runs a verb. Returns its standard output. Every word may name scene files as {NAME}."""
        words = [str(word) for word in words]
        print("sightline-bench", *words, file=sys.stderr, flush=True)
        began = time.monotonic()
        done = subprocess.run([self.program, *map(self.resolve, words)], stdout=subprocess.PIPE, text=True)
        self.seconds += time.monotonic() - began
        if done.returncode != 0:
            raise Failed(" ".join(words))
        self.commands.append(" ".join(["sightline-bench", *words]))
        return done.stdout

    def rows(self, *words):
        """The rows that a verb prints."""
        return [json.loads(line) for line in self.run(*words, "--json").splitlines()]

    def by(self, key, *words):
        """The rows that a verb prints, by one of their columns."""
        return {row[key]: row for row in self.rows(*words)}
