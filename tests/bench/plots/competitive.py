#!/usr/bin/env python3
"""Draws competitive.csv: the time from arrays to all hits over the number of rays, by scene, kind of rays and policy.

    tests/bench/plots/competitive.py FOLDER
"""
import csv
import pathlib
import sys

from style import BLACK, BLUE, GREY, ORANGE, SKY, WINE, plt, save

NAME = "competitive"
# Label, colour, line, width.
POLICIES = {"linear scan": ("search, no tree", GREY, "-", 1.2), "first-touch": ("first touch", SKY, "-", 1.2),
            "full fast": ("full, scan-fast", ORANGE, "-", 1.2), "full best": ("full, scan-best", BLACK, "-", 1.2),
            "embree-low": ("Embree LOW", WINE, ":", 1.2), "embree-medium": ("Embree MEDIUM", WINE, "--", 1.2),
            "demand": ("demand", BLUE, "-", 2.4)}
KINDS = "closeup", "random", "diffuse"


def read(folder):
    """{(scene, kind): {policy: [(rays, seconds)]}}, and the worst ratio of each scene."""
    panels, worst = {}, {}
    with open(folder / f"{NAME}.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["policy"]:
                line = panels.setdefault((row["scene"], row["kind"]), {}).setdefault(row["policy"], [])
                line.append((float(row["rays"]), float(row["seconds"])))
            else:
                worst[row["scene"]] = float(row["competitive_ratio"])
    return panels, worst


def draw_panel(axes, lines):
    for policy, (label, colour, style, width) in POLICIES.items():
        if policy in lines:
            rays, seconds = zip(*lines[policy])
            axes.plot(rays, [1e3 * s for s in seconds], color=colour, ls=style, lw=width, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    best = [value for policy in lines if policy != "linear scan" for _, value in lines[policy]]
    axes.set_ylim(top=4e3 * max(best))  # searching leaves the picture
    axes.grid(color="#eeeeee", lw=0.8)


def draw(panels, worst, folder):
    scenes = list(worst)
    figure, grid = plt.subplots(len(scenes), len(KINDS), figsize=(10, 2.3 * len(scenes) + 1.2), sharex=True, squeeze=False)
    for axes_row, scene in zip(grid, scenes):
        for axes, kind in zip(axes_row, KINDS):
            draw_panel(axes, panels[scene, kind])
            axes.set_title(f"{scene}, {kind}", fontsize=10, loc="left")
        axes_row[0].set_ylabel(f"ms in all\n(worst {worst[scene]:.2f} times the best)")
    for axes in grid[-1]:
        axes.set_xlabel("rays")
    figure.suptitle("From arrays to the last hit: demand stays near the best of all policies, whatever the number of rays",
                    x=0.01, ha="left", fontsize=12)
    figure.tight_layout(rect=(0, 0.04, 1, 1))
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(POLICIES), frameon=False, fontsize=9)
    save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    draw(*read(target), target)
