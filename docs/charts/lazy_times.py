#!/usr/bin/env python3
"""Draws lazy_times.svg and .png: from vertex and index arrays to the hits of a close-up, by scene and way of building.

    docs/charts/lazy_times.py [--bench PATH/TO/sightline-bench] [--scenes DIR] [--repeat R]

Reads lazy_times.csv beside this file; --bench measures that anew first, on one thread; --scenes is where the scene
files are (default: $SIGHTLINE_SCENES). Needs Debian's python3-matplotlib.
"""
import argparse
import csv
import json
import os
import pathlib
import subprocess

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

HERE = pathlib.Path(__file__).resolve().parent
NAME = "lazy_times"
COLUMNS = ["scene", "mode", "seconds_to_hits", "build_ms", "trace_ms", "triangles_total", "triangles_touched",
           "visible_fraction", "touches"]
SCENES = {"dragon": "{}/dragon.ply", "sponza": "{}/sponza.glb", "torcs_forza": "{}/torcs_forza.glb",
          "city, 400 objects": "gen:city?boxes=20000", "city, 3,334 objects": "gen:city?triangles=2000000",
          "terrain": "gen:terrain?triangles=4000000", "herd of 100 bunnies": "gen:herd?copies=100&mesh={}/bunny.ply"}
MODES = {"lazy": ("Sightline, lazy", "#0072b2"), "full": ("Sightline, full", "#9ec9e8"),
         "embree-low": ("Embree LOW", "#e69f00"), "embree-lazy": ("Embree, objects on first hit", "#d55e00")}


def measure(options):
    """Runs the bench and keeps its rows as CSV."""
    with open(HERE / f"{NAME}.csv", "w", newline="") as file:
        out = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        out.writeheader()
        for name, scene in SCENES.items():
            command = [options.bench, "lazy", "--scene", scene.format(options.scenes), "--rays", "closeup", "--count",
                       "10000", "--modes", ",".join(MODES), "--threads", "1", "--repeat", str(options.repeat), "--json"]
            lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
            for row in map(json.loads, lines):
                row["scene"] = name
                out.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def read():
    """By scene, in the file's order, by mode: milliseconds; and the scenes' triangles."""
    times, triangles = {}, {}
    with open(HERE / f"{NAME}.csv", newline="") as file:
        for row in csv.DictReader(file):
            times.setdefault(row["scene"], {})[row["mode"]] = 1e3 * float(row["seconds_to_hits"])
            triangles[row["scene"]] = int(row["triangles_total"])
    return times, triangles


def draw(times, triangles):
    plt.rcParams.update({"svg.hashsalt": NAME, "font.size": 10, "axes.spines.top": False, "axes.spines.right": False})
    figure, axes = plt.subplots(figsize=(9, 0.95 * len(times) + 1.4))
    height = 0.8 / len(MODES)
    for i, (scene, by_mode) in enumerate(times.items()):
        for k, (mode, (_, colour)) in enumerate(MODES.items()):
            if mode not in by_mode:
                continue
            y = i + (k - (len(MODES) - 1) / 2) * height
            axes.barh(y, by_mode[mode], 0.92 * height, color=colour, zorder=2)
            text = f"{by_mode[mode]:.3g}" if by_mode[mode] < 100 else f"{by_mode[mode]:,.0f}"
            axes.annotate(text, (by_mode[mode], y), xytext=(3, 0), textcoords="offset points", va="center",
                          fontsize=8, color="#333333")
    axes.set_yticks(range(len(times)), [f"{s}\n{triangles[s]:,} triangles" for s in times])
    axes.invert_yaxis()
    axes.set_xscale("log")
    low = min(min(t.values()) for t in times.values())
    axes.set_xlim(low / 1.6, 2.2 * max(max(t.values()) for t in times.values()))
    axes.set_xlabel("ms from vertex and index arrays to 10,000 hits, one thread, logarithmic")
    axes.grid(axis="x", color="#eeeeee", lw=0.8, zorder=0)
    axes.set_axisbelow(True)
    axes.tick_params(axis="y", length=0)
    figure.suptitle("The first close-up of a scene, from nothing but arrays: building where rays look, and building everything", x=0.01, ha="left", fontsize=12)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour, label=label) for label, colour in MODES.values()]
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncol=len(MODES), frameon=False, fontsize=9)
    figure.savefig(HERE / f"{NAME}.svg", metadata={"Date": None})
    figure.savefig(HERE / f"{NAME}.png", dpi=110)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", help="measure anew with this sightline-bench")
    parser.add_argument("--scenes", default=os.environ.get("SIGHTLINE_SCENES"), help="folder of the scene files")
    parser.add_argument("--repeat", type=int, default=5, help="medians of so many")
    options = parser.parse_args()
    if options.bench:
        if options.scenes is None:
            parser.error("the scenes are in no folder: give --scenes or SIGHTLINE_SCENES")
        measure(options)
    draw(*read())
