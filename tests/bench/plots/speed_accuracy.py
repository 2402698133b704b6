#!/usr/bin/env python3
"""Draws what `sightline-bench chart` has measured.

    tests/bench/plots/speed_accuracy.py CSV

Writes builders.csv, images.csv, provenance.json and two charts beside the CSV, and prints the names of the charts. Needs
Debian's python3-matplotlib; without it: exit code 3.
"""
import csv
import importlib.util
import json
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "data"))

from builders import builder_rows, image_rows
from csv_files import PROVENANCE, write_csv

NO_MATPLOTLIB = 3


def main(path):
    if importlib.util.find_spec("matplotlib") is None:
        print("no matplotlib; Debian has it as python3-matplotlib", file=sys.stderr)
        return NO_MATPLOTLIB
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    run = {key: rows[0][key] for key in ("machine", "compiler", "commit", "date")} | {"repeat": int(rows[0]["repeat"])}
    files = {"builders": builder_rows(rows), "images": image_rows(rows)}
    (path.parent / PROVENANCE).write_text(json.dumps({f"{name}.csv": run for name in files}, indent=1) + "\n")
    for name, table in files.items():
        write_csv(path.parent / f"{name}.csv", table)
        subprocess.run([sys.executable, HERE / f"{name}.py", path.parent], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
