"""Runs sightline-bench for the tables, remembers its rows, and prints numbers as people read them."""
import json
import math
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
GLB = ["sponza", "torcs_forza"]  # the other scenes are .ply


class Failed(Exception):
    pass


class Bench:
    """Runs the program, or remembers that it did."""

    def __init__(self, options):
        self.program, self.scenes, self.cache, self.fresh = options.bench, options.scenes, options.cache, options.fresh
        self.known = {}
        if self.cache.exists():
            for line in self.cache.read_text().splitlines():
                entry = json.loads(line)
                self.known[entry["command"]] = entry["rows"]

    def scene(self, name):
        """A file's path for its name; inside gen:...&mesh=NAME too."""
        if name.startswith("gen:"):
            return re.sub(r"mesh=(\w+)$", lambda found: "mesh=" + self.scene(found[1]), name)
        return str(self.scenes / (name + (".glb" if name in GLB else ".ply")))

    def rows(self, *words):
        """All rows of a command line, which is given without --json; --scene NAME is looked up."""
        command = " ".join(map(str, words))
        if self.fresh or command not in self.known:
            print("running", command, file=sys.stderr)
            words = [self.scene(word) if before == "--scene" else str(word) for before, word in zip(("", *words), words)]
            done = subprocess.run([self.program, *words, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            sys.stderr.write(done.stderr)
            if done.returncode != 0:
                raise Failed(command)
            self.known[command] = [json.loads(line) for line in done.stdout.splitlines()]
            self.cache.parent.mkdir(parents=True, exist_ok=True)
            with open(self.cache, "a") as file:
                file.write(json.dumps({"command": command, "rows": self.known[command]}) + "\n")
        return self.known[command]

    def run(self, verb, scene, builders, threads, repeat, *more):
        """One row a builder, by its name."""
        rows = self.rows(verb, "--scene", scene, "--builder", ",".join(builders), "--threads", threads, "--repeat", repeat, *more)
        return {row["builder"]: row for row in rows}


def show(value, digits=3):
    """A number as people read it: 3 digits, thousands apart."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    if value == 0:
        return "0"
    if abs(value) >= 1000 or float(value).is_integer():
        return f"{value:,.0f}"
    return f"{value:.{max(0, digits - 1 - math.floor(math.log10(abs(value))))}f}"


def print_table(title, heads, rows):
    print(f"\n**{title}**\n")
    print("| " + " | ".join(heads) + " |")
    print("| --- |" + " ---: |" * (len(heads) - 1))
    for row in rows:
        print("| " + " | ".join(show(cell) for cell in row) + " |")


def first_line(*command):
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    return done.stdout.splitlines()[0] if done.returncode == 0 and done.stdout else "unknown"
