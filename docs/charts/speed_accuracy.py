#!/usr/bin/env python3
"""Draws the charts of speed against accuracy: what building costs, what it buys, and what exact hits cost.

    docs/charts/speed_accuracy.py [CSV] [--out DIR]

CSV is what `sightline-bench chart` wrote (default: speed_accuracy.csv beside this file); pictures go beside it, or to
--out, as SVG and PNG, and their names to standard output. Needs Debian's python3-matplotlib; without it: exit code 3.
"""
import argparse
import csv
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
NO_MATPLOTLIB = 3


class Data:
    """The CSV's rows; empty cells are not there, numbers are numbers."""
    TEXTS = {"study", "scene", "builder", "configuration", "line", "value", "policy", "method", "rays", "basis",
             "hit_hash", "rotate", "machine", "compiler", "commit", "date"}

    def __init__(self, path):
        with open(path, newline="") as file:
            self.rows = [{k: v if k in self.TEXTS else float(v) for k, v in row.items() if v != ""}
                         for row in csv.DictReader(file)]
        for row in self.rows:
            for key in "threads", "repeat":
                row[key] = int(row[key])

    def of(self, study):
        return [row for row in self.rows if row["study"] == study]

    def scenes(self):
        return list(dict.fromkeys(row["scene"] for row in self.of("build")))


def mean(values):
    """Geometric; of none: none."""
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values and min(values) > 0 else None


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="?", type=pathlib.Path, default=HERE / "speed_accuracy.csv")
    parser.add_argument("--out", type=pathlib.Path, help="default: the CSV's folder")
    options = parser.parse_args()
    try:
        import matplotlib
    except ImportError:
        print("no matplotlib; Debian has it as python3-matplotlib", file=sys.stderr)
        sys.exit(NO_MATPLOTLIB)
    import speed_accuracy_builders
    import speed_accuracy_rays
    if not options.csv.is_file():
        parser.error(f"no file {options.csv}: write it by sightline-bench chart --out {options.csv.parent}")
    data = Data(options.csv)
    if not data.rows:
        parser.error(f"{options.csv} has no measurements")
    folder = options.out or options.csv.resolve().parent
    folder.mkdir(parents=True, exist_ok=True)
    for draw in (*speed_accuracy_builders.FIGURES, *speed_accuracy_rays.FIGURES):
        for path in draw(data, folder, mean):
            print(path)
