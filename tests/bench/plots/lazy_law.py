#!/usr/bin/env python3
"""Draws lazy_law.csv: the touches of trees that rays grow, and the law fitted to them.

    tests/bench/plots/lazy_law.py FOLDER
"""
import csv
import math
import pathlib
import sys

from style import plt, save

NAME = "lazy_law"
NUMBERS = "n", "m", "share", "windows", "touches", "a", "b", "r_squared", "max_residual"
TITLES = {"soup": "every triangle a reference of its own", "runs": "runs of triangles, opened where rays look"}
COLOURS = ["#56b4e9", "#0072b2", "#009e73", "#e69f00", "#d55e00"]


def read(folder):
    """The points, and the fit of each hierarchy."""
    with open(folder / f"{NAME}.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["what"] in ("point", "fit")]
    for row in rows:
        for key in NUMBERS:
            row[key] = float(row[key]) if row[key] else None
    return [r for r in rows if r["what"] == "point"], {r["hierarchy"]: r for r in rows if r["what"] == "fit"}


def draw_hierarchy(axes, points, fit, sizes):
    for n, colour in zip(sizes, COLOURS):
        line = sorted((p for p in points if p["n"] == n), key=lambda p: p["m"])
        low, high = line[0]["m"], line[-1]["m"]
        curve = [low * (high / low) ** (i / 200) for i in range(201)]
        axes.plot(curve, [fit["a"] * n + fit["b"] * m * math.log2(max(m, 1)) for m in curve], color=colour, lw=1.4, zorder=2)
        axes.plot([p["m"] for p in line], [p["touches"] for p in line], "o", ms=5, mfc="white", mec=colour, mew=1.4, zorder=3)
        label = f"n = 2$^{{{round(math.log2(n))}}}$"
        axes.annotate(label, (line[0]["m"], line[0]["touches"]), xytext=(-6, 0), textcoords="offset points", ha="right",
                      va="center", color=colour, fontsize=9)
    axes.set_title(f"{TITLES[fit['hierarchy']]}\n{fit['a']:.2g} n + {fit['b']:.2g} m log$_2$ m, "
                   f"R² {fit['r_squared']:.3f}, largest residual {fit['max_residual']:.2f}", fontsize=10)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    low, high = axes.get_xlim()
    axes.set_xlim(low / 12, high)
    axes.set_xlabel("m, triangles in the leaves that rays entered")
    axes.grid(color="#eeeeee", lw=0.8)
    axes.set_axisbelow(True)


def draw(points, fits, folder):
    figure, panels = plt.subplots(1, len(fits), figsize=(5.2 * len(fits), 4.8), sharey=True, squeeze=False)
    every = sorted({p["n"] for p in points})
    sizes = every[::max(1, len(every) // len(COLOURS) + (len(every) % len(COLOURS) > 0))]
    for axes, (hierarchy, fit) in zip(panels[0], fits.items()):
        draw_hierarchy(axes, [p for p in points if p["hierarchy"] == hierarchy], fit, sizes)
    panels[0][0].set_ylabel("touches: bounds read by passes of building")
    figure.suptitle("The cost of a tree that rays grow: one term for the size of the scene, one for what the rays see",
                    x=0.01, ha="left", fontsize=12)
    windows = max(round(p["windows"]) for p in points)
    handles = [plt.Line2D([], [], color="#555555", marker="o", mfc="white", mew=1.4, ls="", label=f"counted, median of {windows} windows"),
               plt.Line2D([], [], color="#555555", lw=1.4, label="the law, one fit for all sizes")]
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncol=2, frameon=False, fontsize=9)
    save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    draw(*read(target), target)
