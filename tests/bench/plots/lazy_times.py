#!/usr/bin/env python3
"""Draws lazy_times.csv: the time from vertex and index arrays to the hits of a close-up, by scene and way of building.

    tests/bench/plots/lazy_times.py FOLDER
"""
import csv
import pathlib
import sys

from style import plt, save

NAME = "lazy_times"
MODES = {"lazy": ("Sightline, lazy", "#0072b2"), "full": ("Sightline, full", "#9ec9e8"),
         "embree-low": ("Embree LOW", "#e69f00"), "embree-lazy": ("Embree, objects on first hit", "#d55e00")}


def read(folder):
    """By scene, in the file's order, by mode: milliseconds; and the scenes' triangles."""
    times, triangles = {}, {}
    with open(folder / f"{NAME}.csv", newline="") as file:
        for row in (row for row in csv.DictReader(file) if row["rays"] == "closeup"):
            times.setdefault(row["scene"], {})[row["mode"]] = 1e3 * float(row["seconds_to_hits"])
            triangles[row["scene"]] = int(row["triangles_total"])
    return times, triangles


def draw(times, triangles, folder):
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
    figure.suptitle("The first close-up of a scene, from arrays to hits: building where rays look, and building everything", x=0.01, ha="left", fontsize=12)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour, label=label) for label, colour in MODES.values()]
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncol=len(MODES), frameon=False, fontsize=9)
    save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    draw(*read(target), target)
