#!/usr/bin/env python3
"""Draws images.csv: the time from arrays to hits, building included, against the number of rays.

    tests/bench/plots/images.py FOLDER
"""
import math
import pathlib
import sys

from style import BLACK, BLUE, GREEN, LIGHT, ORANGE, PURPLE, RED, SKY, WINE, caption, log_ticks, plt, save

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "data"))
from csv_files import read_csv, read_provenance

NAME = "images"

# Ways to build: name in the chart, short name in the bands, colour, dashes.
WAYS = {("scan-fast", "first-touch"): ("lazy scan-fast", "lazy", BLUE, "-"),
        ("scan-fast", "full"): ("full scan-fast", "fast", SKY, "-"),
        ("scan-one-axis", "full"): ("full scan-one-axis", "one", PURPLE, "-"),
        ("scan-best", "full"): ("full scan-best", "best", ORANGE, "-"),
        ("bvh-binned", "full"): ("full bvh-binned", "bvh", GREEN, "-"),
        ("sbvh", "full"): ("full sbvh", "sbvh", RED, "-"),
        ("embree-low", "full"): ("Embree LOW", "LOW", "#bb6688", "--"),
        ("embree-medium", "full"): ("Embree MEDIUM", "MED", WINE, "--"),
        ("embree-high", "full"): ("Embree HIGH", "HIGH", BLACK, "--")}
PICTURES = {"overview": "the whole scene in view", "closeup": "a close-up: at most 1 % of it in view"}


def peer(way):
    return way[0].startswith("embree")


def mean(values):
    """The geometric mean."""
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values))


def image_times(rows):
    """By kind of picture, scene, way: {rays: seconds}."""
    times = {}
    for row in rows:
        ways = times.setdefault(row["rays"], {}).setdefault(row["scene"], {})
        ways.setdefault((row["builder"], row["policy"]), {})[int(row["count"])] = row["seconds_to_hits"]
    return times


def spread(wanted, least):
    """Heights as near as may be to those wanted, at least so far from each other, in their order."""
    order = sorted(range(len(wanted)), key=lambda i: wanted[i])
    heights = [wanted[i] for i in order]
    for _ in range(200):
        for i in range(1, len(heights)):
            gap = least - (heights[i] - heights[i - 1])
            if gap > 0:
                heights[i - 1] -= gap / 2
                heights[i] += gap / 2
    result = [0.0] * len(wanted)
    for i, height in zip(order, heights):
        result[i] = height
    return result


def draw_times(axes, by_scene, told_from):
    ways = [w for w in WAYS if all(w in s for s in by_scene.values())]
    counts = sorted(next(iter(next(iter(by_scene.values())).values())))
    curves = {w: [1e3 * mean(s[w][n] for s in by_scene.values()) for n in counts] for w in ways}
    axes.set_xscale("log")
    axes.set_yscale("log")
    for way, curve in curves.items():
        _, _, colour, dashes = WAYS[way]
        axes.plot(counts, curve, dashes, color=colour, lw=2.4 if way[1] == "first-touch" else 1.4, zorder=3)
    lowest, highest = min(min(c) for c in curves.values()), max(max(c) for c in curves.values())
    axes.set_ylim(lowest / 1.5, highest * 1.4)
    log_ticks(axes.yaxis, lowest / 1.5, highest * 1.4, (1,))
    axes.set_xlim(counts[0] / 500, counts[-1] * 1.6)  # room for names
    axes.set_xticks(counts, [count_text(n) for n in counts])
    axes.set_xticks([], minor=True)
    if told_from is not None:
        axes.axvspan(told_from, counts[-1] * 1.6, color=LIGHT, zorder=0)
    axes.grid(color=LIGHT, lw=0.8, zorder=0)
    axes.set_axisbelow(True)
    return ways, {w: c[0] for w, c in curves.items()}


def name_curves(axes, first):
    """To the left of the first points, where the curves lie farthest apart."""
    to_axes = lambda y: axes.transAxes.inverted().transform(axes.transData.transform((1, y)))[1]
    heights = spread([to_axes(y) for y in first.values()], 0.052)
    x = axes.transAxes.inverted().transform(axes.transData.transform((1, 1)))[0]
    for (way, y), height in zip(first.items(), heights):
        text, _, colour, _ = WAYS[way]
        axes.text(x - 0.035, height, text, transform=axes.transAxes, fontsize=8.5, color=colour, ha="right",
                  va="center", fontweight="bold" if way[1] == "first-touch" else "normal")
        axes.plot([x - 0.03, x - 0.004], [height, to_axes(y)], transform=axes.transAxes, color=colour, lw=0.7)


def count_text(n):
    return {1: "1", 10: "10", 100: "100"}.get(n) or (f"{n // 1000}K" if n < 10 ** 6 else f"{n // 10 ** 6}M")


def draw_bands(axes, by_scene, ways, title):
    """One line a scene, one cell a number of rays: the fastest way."""
    scenes = list(by_scene)
    counts = sorted(next(iter(by_scene[scenes[0]].values())))
    for i, scene in enumerate(scenes):
        for k, n in enumerate(counts):
            winner = min(ways, key=lambda w: by_scene[scene][w][n])
            _, short, colour, _ = WAYS[winner]
            axes.add_patch(plt.Rectangle((k, i), 0.97, 0.94, color=colour, lw=0))
            ink = BLACK if colour in (SKY, ORANGE, PURPLE) else "white"
            axes.text(k + 0.485, i + 0.49, short, ha="center", va="center", fontsize=7.5, color=ink)
    axes.set_xlim(0, len(counts))
    axes.set_ylim(len(scenes), 0)
    axes.set_xticks([k + 0.5 for k in range(len(counts))], [count_text(n) for n in counts], fontsize=8)
    axes.set_yticks([i + 0.5 for i in range(len(scenes))], scenes, fontsize=8)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_title(title, fontsize=9, loc="left")


def draw(rows, run, folder):
    times = image_times(rows)
    measured = max(int(r["count"]) for r in rows if r["basis"] == "measured")
    told = [int(r["count"]) for r in rows if r["basis"] == "extrapolated"]
    told_from = (measured * min(told)) ** 0.5 if told else None
    kinds = [k for k in PICTURES if k in times]
    scenes = len(times[kinds[0]])
    tables = ["the fastest of ours"]
    if any(peer(way) for by_way in times[kinds[0]].values() for way in by_way):
        tables.append("the fastest, Embree included")
    band = 0.45 + 0.26 * scenes
    figure, grid = plt.subplots(1 + len(tables), len(kinds), squeeze=False,
                                figsize=(6.7 * len(kinds), 6.3 + len(tables) * (band + 0.4)),
                                gridspec_kw={"height_ratios": [5.4] + [band] * len(tables)})
    named = []
    for (top, *below), kind in zip(grid.T, kinds):
        ways, first = draw_times(top, times[kind], told_from)
        named.append((top, first))
        of = f" (geometric mean of {scenes} scenes)" if scenes > 1 else ""
        top.set_title(PICTURES[kind] + of, fontsize=10, loc="left")
        top.set_xlabel("rays")
        for axes, title in zip(below, tables):
            draw_bands(axes, times[kind], [w for w in ways if axes is not below[0] or not peer(w)], title)
    grid[0][0].set_ylabel("ms from vertex and index arrays to all hits")
    figure.suptitle("Time to image: building and tracing together", x=0.01, ha="left", fontsize=13)
    figure.tight_layout(rect=(0, 0.03, 1, 0.99))
    figure.canvas.draw()
    for axes, first in named:
        name_curves(axes, first)
    shaded = f"; shaded: extrapolated from {count_text(measured)} rays and what one more costs" if told else ""
    caption(figure, run, f"{count_text(measured)} rays in one round{shaded}")
    return save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    print(draw(read_csv(target / f"{NAME}.csv"), read_provenance(target)[f"{NAME}.csv"], target))
