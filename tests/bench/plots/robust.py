#!/usr/bin/env python3
"""Draws robust.csv: the rays that methods answer wrong on closed scenes, against the speed of the methods.

    tests/bench/plots/robust.py FOLDER
"""
import csv
import pathlib
import sys

from style import plt, save

NAME = "robust"
FAMILIES = {"icosphere-0": "sphere at the origin", "icosphere-1e3": "1,000 radii away",
            "icosphere-1e5": "100,000 radii away", "icosphere-1e7": "10,000,000 radii away",
            "mesh-in-box": "bunny in a box"}
METHODS = {"exact": ("Sightline, exact", "#0072b2", "o"), "plain-float": ("the same in plain float", "#e69f00", "s"),
           "embree": ("Embree", "#d55e00", "^"), "embree-robust": ("Embree ROBUST", "#009e73", "D")}
BUILDER = "scan-fast"  # the builder whose rows are drawn; the CSV has all
NONE = 2e-5  # where a share of zero is drawn, in percent


def read(folder):
    """By family and method, over all kinds of rays, full trees: speed, and shares of missed and extra in percent."""
    sums = {}
    with open(folder / f"{NAME}.csv", newline="") as file:
        for row in csv.DictReader(file):
            if row["policy"] != "full" or row["method"] == "exact" and row["builder"] != BUILDER:
                continue
            s = sums.setdefault((row["family"], row["method"]), [0, 0, 0, 0.0])
            rays = int(row["rays"])
            s[0] += rays
            s[1] += int(row["missed"])
            s[2] += int(row["extra"])
            s[3] += rays / float(row["mrays_per_s"])
    return {key: (rays / time, 100 * missed / rays, 100 * extra / rays)
            for key, (rays, missed, extra, time) in sums.items()}


def draw_family(axes, family, figures):
    for method, (label, colour, marker) in METHODS.items():
        if (family, method) not in figures:
            continue
        speed, missed, extra = figures[family, method]
        low, high = sorted((max(missed, NONE), max(extra, NONE)))
        axes.plot([speed, speed], [low, high], color=colour, lw=1, alpha=0.5, zorder=2)
        axes.plot(speed, max(extra, NONE), marker, ms=9, mfc="white", mec=colour, mew=1.6, zorder=3)
        axes.plot(speed, max(missed, NONE), marker, ms=6 if missed == extra else 9, mfc=colour, mec=colour, zorder=4)
    axes.set_title(FAMILIES[family], fontsize=10)
    axes.set_xscale("log")
    axes.set_xticks([0.01, 0.1, 1, 10], ["0.01", "0.1", "1", "10"])
    axes.set_xlim(0.002, 40)
    axes.set_yscale("log")
    axes.set_ylim(NONE / 2.2, 150)
    axes.axhline(NONE * 2.2, color="#999999", lw=0.8, ls=(0, (2, 2)), zorder=1)
    axes.set_yticks([NONE, 1e-4, 1e-3, 1e-2, 1e-1, 1, 10, 100],
                    ["none", "0.0001 %", "0.001 %", "0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
    axes.minorticks_off()
    axes.grid(color="#eeeeee", lw=0.8, zorder=0)
    axes.set_axisbelow(True)


def draw(figures, folder):
    families = [f for f in FAMILIES if any((f, m) in figures for m in METHODS)]
    figure, panels = plt.subplots(1, len(families), figsize=(2.6 * len(families) + 1, 4.6), sharey=True)
    for axes, family in zip(panels, families):
        draw_family(axes, family, figures)
        axes.set_xlabel("Mrays/s")
    panels[0].set_ylabel("share of rays answered wrong")
    handles = [plt.Line2D([], [], color=c, marker=m, ls="", ms=8, label=label) for label, c, m in METHODS.values()]
    handles += [plt.Line2D([], [], color="#555555", marker="o", ls="", ms=8, label="filled: lost a crossing"),
                plt.Line2D([], [], color="#555555", marker="o", mfc="white", mew=1.6, ls="", ms=8,
                           label="hollow: counted one too many")]
    figure.suptitle("Rays at vertices, at edges, at random and along axes through closed meshes: "
                    "exact hits lose none", x=0.01, ha="left", fontsize=12)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncol=6, frameon=False, fontsize=9)
    save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    draw(read(target), target)
