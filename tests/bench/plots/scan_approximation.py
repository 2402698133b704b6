#!/usr/bin/env python3
"""Draws scan_approximation.csv: the cost that sixteen samples suggest, beside the true cost, at a wall.

    tests/bench/plots/scan_approximation.py FOLDER
"""
import csv
import pathlib
import sys

from style import plt, save

NAME = "scan_approximation"
WALL = 0.62
COLUMNS = ["what", "position", "left", "right", "cost"]
TRUE, SUGGESTED, UNIFORM, ADAPTIVE = "#444444", "#0072b2", "#0072b2", "#d55e00"


def read(folder):
    """Rows by what they are: lists of (position, left, right, cost)."""
    rows = {}
    with open(folder / f"{NAME}.csv", newline="") as file:
        for row in csv.DictReader(file):
            rows.setdefault(row["what"], []).append([float(row[c]) for c in COLUMNS[1:]])
    return rows


def column(rows, what, f):
    return [r[0] for r in rows[what]], [f(*r) for r in rows[what]]


def draw_counts(axes, rows):
    difference = lambda x, left, right, cost: (left - right) / 1000
    axes.plot(*column(rows, "true", difference), color=TRUE, lw=1.2, label="true")
    axes.plot(*column(rows, "uniform", difference), "o", color=UNIFORM, ms=6, label="8 uniform samples")
    axes.plot(*column(rows, "adaptive", difference), "D", color=ADAPTIVE, ms=5, label="8 adaptive samples")
    axes.set_ylabel("$C_L - C_R$, thousands")
    axes.set_title("The wall holds half of 10,000 triangles: half of the adaptive samples go to its segment", fontsize=10,
                   loc="left")
    axes.legend(loc="upper left", frameon=False, fontsize=9)


def draw_cost(axes, rows, legend):
    cost = lambda x, left, right, cost: cost / 1000
    axes.plot(*column(rows, "true", cost), color=TRUE, lw=1.2, label="true cost")
    axes.plot(*column(rows, "suggested", cost), color=SUGGESTED, lw=1.6, ls="--", label="cost suggested by the samples")
    for what, marker, colour, size in (("uniform", "o", UNIFORM, 6), ("adaptive", "D", ADAPTIVE, 5)):
        axes.plot(*column(rows, what, cost), marker, color=colour, ms=size)
    for what, marker, colour, label in (("true", "*", TRUE, "true minimum"),
                                        ("suggested", "v", SUGGESTED, "suggested minimum")):
        best = min(rows[what], key=lambda r: r[3])
        axes.plot(best[0], best[3] / 1000, marker, color=colour, ms=11, mec="white", label=label, zorder=5)
    if legend:
        axes.legend(loc="lower left", frameon=False, fontsize=9)


def draw(rows, folder):
    figure, (counts, cost) = plt.subplots(2, 1, figsize=(8, 7.4), sharex=True, gridspec_kw={"height_ratios": [1, 1.5]})
    draw_counts(counts, rows)
    draw_cost(cost, rows, legend=True)
    cost.set_xlabel("position of the plane on the x axis")
    cost.set_ylabel("cost of the cut, thousands of tests")
    cost.set_title("Cost: off by at most the rise of a segment, within its width", fontsize=10, loc="left")

    near = cost.inset_axes([0.30, 0.53, 0.29, 0.38])
    draw_cost(near, rows, legend=False)
    near.set_xlim(WALL - 0.012, WALL + 0.022)
    lows = [r[3] / 1000 for r in rows["true"] + rows["suggested"] if WALL - 0.012 < r[0] < WALL + 0.022]
    near.set_ylim(min(lows) - 0.1, max(lows) + 0.1)
    near.set_title("at the wall", fontsize=9)
    near.tick_params(labelsize=8)
    cost.indicate_inset_zoom(near, edgecolor="#999999")
    figure.align_ylabels()
    figure.tight_layout()
    save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    draw(read(target), target)
