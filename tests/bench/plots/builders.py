#!/usr/bin/env python3
"""Draws builders.csv: the time of rays in the trees of each builder, against the speed of building.

    tests/bench/plots/builders.py FOLDER
"""
import math
import pathlib
import sys

from style import BLACK, BVH, GREY, KD, LIGHT, OURS, PEER, Labels, caption, log_ticks, look, plt, save

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "data"))
from csv_files import read_csv, read_provenance

NAME = "builders"
KINDS = "overview", "diffuse", "random"
TURNED = "turned"  # scenes whose name ends so are left out: they are of one more scene that is there
CEILING = 2.5      # points above it lie at it, with their figure
FINE = 1, 1.1, 1.2, 1.4, 1.6, 2, 2.5, 3, 4, 7, 8, 9


class Point:
    def __init__(self, row, x, y):
        self.builder, self.text = row["builder"], row["configuration"]
        self.line, self.value = row.get("line", ""), row.get("value", "")
        if isinstance(self.value, float):
            self.value = f"{self.value:g}"
        self.default, self.x, self.y = row["default"] == "yes", x, y


def mean(values):
    """The geometric mean."""
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values))


def points(rows, scenes):
    """One point a configuration: geometric means over the scenes and the kinds of rays."""
    groups = {}
    for row in rows:
        if row["scene"] in scenes:
            groups.setdefault(row["configuration"], []).append(row)
    return [Point(group[0], mean(row["mtris_per_s"] for row in group),
                  mean(row[f"{kind}_time_over_sweep"] for row in group for kind in KINDS)) for group in groups.values()]


def front(found):
    """The points that no other point beats in both coordinates."""
    best, kept = float("inf"), []
    for p in sorted(found, key=lambda p: (-p.x, p.y)):
        if p.y < best:
            best = p.y
            kept.append(p)
    return kept


def lines(found):
    """Points that vary one parameter, in the order measured. One alone is joined to its builder as it usually is."""
    defaults = {p.builder: p for p in found if p.default}
    groups = {}
    for p in found:
        if p.line:
            groups.setdefault((p.builder, p.line), []).append(p)
    for (builder, line), group in groups.items():
        if len(group) == 1 and not group[0].default and builder in defaults:
            group = [defaults[builder], *group]
        if len(group) > 1:
            yield line, group


def mark(axes, p, y):
    colour, marker = look(p.builder)
    size = 8 if p.default else 4.5
    axes.plot(p.x, y, marker, ms=size, mfc=colour if p.default else "white", mec=colour, mew=1.2,
              zorder=4 if p.default else 3)


class Panel:
    """One panel: points, lines, fronts, labels. Points above the ceiling lie at it, with their figure."""

    def __init__(self, axes, found):
        self.axes, self.found = axes, found
        self.labels = Labels(axes)

    def y(self, p):
        return min(p.y, CEILING)

    def draw_front(self):
        kept = front([p for p in self.found if look(p.builder)[1] in (KD, BVH)])
        members = {p.text for p in kept}
        kept = [p for p in kept if p.y <= CEILING]
        self.axes.plot([p.x for p in kept], [p.y for p in kept], color="#bbbbbb", lw=5, alpha=0.55, zorder=1,
                       solid_capstyle="round", solid_joinstyle="round")
        return members

    def draw_points(self):
        for _, group in lines(self.found):
            colour = look(group[0].builder)[0]
            self.axes.plot([p.x for p in group], [self.y(p) for p in group], color=colour, lw=1.1,
                           alpha=0.8, zorder=2)
            for a, b in zip(group, group[1:]):
                self.labels.avoid_line((a.x, self.y(a)), (b.x, self.y(b)))
        for p in self.found:
            mark(self.axes, p, self.y(p))
            self.labels.avoid(p.x, self.y(p))

    def name(self, p):
        text = (p.builder if p.default else p.text) + (f" {p.y:.1f}x" if p.y > CEILING else "")
        self.labels.add(p.x, self.y(p), text, look(p.builder)[0], 9 if p.default else 7, "bold" if p.builder in OURS else "normal")


def limits(axes, found):
    low, high = min(p.x for p in found), max(p.x for p in found)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(low / 1.5, high * 1.5)
    log_ticks(axes.xaxis, low / 1.5, high * 1.5)
    bottom = min(p.y for p in found) / 1.1
    top = min(max(p.y for p in found), CEILING) * 1.05
    axes.set_ylim(bottom, top)
    log_ticks(axes.yaxis, bottom, top, FINE if top / bottom < 5 else (1, 2, 5))


def draw_panel(axes, found, scenes):
    """All scenes together, with labels at the axes."""
    limits(axes, found)
    axes.set_xlabel("million triangles built a second")
    axes.set_ylabel("time to trace over that in the exact sweep's trees")
    axes.set_title(f"geometric mean of {len(scenes)} scenes", fontsize=10, loc="left")
    axes.text(0.995, 0.012, "faster to build, faster to trace: better", transform=axes.transAxes, fontsize=9, color=GREY,
              style="italic", ha="right", va="bottom")
    panel = Panel(axes, found)
    members = panel.draw_front()
    panel.draw_points()
    axes.axhline(1, color="#999999", lw=0.8, ls=(0, (3, 3)), zorder=0)
    for p in found:
        if p.default or p.text in members:
            panel.name(p)
    axes.grid(color=LIGHT, lw=0.8, zorder=0)
    axes.set_axisbelow(True)
    return panel


def legend(figure, found):
    marks = {look(p.builder)[1] for p in found}
    handles = [plt.Line2D([], [], color=BLACK, marker=m, ls="", ms=7, label=text)
               for m, text in ((KD, "kd-tree"), (BVH, "BVH"), (PEER, "Embree")) if m in marks]
    handles += [plt.Line2D([], [], color=GREY, marker="o", ls="", ms=7, label="filled: default parameters"),
                plt.Line2D([], [], color=GREY, marker="o", mfc="white", ls="-", ms=4.5, label="one parameter varied"),
                plt.Line2D([], [], color="#bbbbbb", lw=5, alpha=0.55, label="the best of ours")]
    figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.005, 0.02), ncol=len(handles), frameon=False,
                  fontsize=9)


def draw(rows, run, folder):
    scenes = [scene for scene in dict.fromkeys(row["scene"] for row in rows) if not scene.endswith(TURNED)]
    everything = points(rows, scenes)
    figure, axes = plt.subplots(figsize=(13, 8.2))
    panel = draw_panel(axes, everything, scenes)
    figure.suptitle("The price of a fast build: time to trace against speed of building", x=0.01, ha="left", fontsize=13)
    figure.tight_layout(rect=(0, 0.07, 1, 0.99))
    legend(figure, everything)
    figure.canvas.draw()
    panel.labels.place()
    caption(figure, run, "overview, diffuse and random rays")
    return save(figure, folder, NAME)


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    print(draw(read_csv(target / f"{NAME}.csv"), read_provenance(target)[f"{NAME}.csv"], target))
