"""Three charts of builders: work and time to trace against the speed of building, and SAH cost against its time."""
from speed_accuracy_style import BLACK, BVH, GREY, KD, LIGHT, OURS, PEER, Labels, caption, log_ticks, look, plt, save

SWEEP = "sah-sweep?clip=off"
COLUMNS = 3
FINE = 1, 1.1, 1.2, 1.4, 1.6, 2, 2.5, 3, 4, 7, 8, 9


class Point:
    def __init__(self, row, x, y):
        self.builder, self.text = row["builder"], row["configuration"]
        self.line, self.value = row.get("line", ""), row.get("value", "")
        self.usual, self.x, self.y = row["usual"] == 1, x, y


def points(data, mean, scenes, x, y):
    """A point a configuration that has both figures: geometric means over the scenes (and kinds of rays)."""
    found = []
    rows = {}
    for row in data.rows:
        if row["study"] in ("build", "trace") and row["scene"] in scenes:
            rows.setdefault(row["configuration"], []).append(row)
    for group in rows.values():
        at = [mean(f(r) for r in group if f(r) is not None) for f in (x, y)]
        if None not in at:
            found.append(Point(group[0], *at))
    return found


def front(found, further):
    """Those that no other beats in both; `further` is +1 where a larger x is better, else -1."""
    best, kept = float("inf"), []
    for p in sorted(found, key=lambda p: (-further * p.x, p.y)):
        if p.y < best:
            best = p.y
            kept.append(p)
    return kept


def lines(found):
    """Points that vary one parameter, in the order measured. One alone is joined to its builder as it usually is."""
    usual = {p.builder: p for p in found if p.usual}
    groups = {}
    for p in found:
        if p.line:
            groups.setdefault((p.builder, p.line), []).append(p)
    for (builder, line), group in groups.items():
        if len(group) == 1 and not group[0].usual and builder in usual:
            group = [usual[builder], *group]
        if len(group) > 1:
            yield line, group


def value_label(p):
    """A value with its parameter; of a switch: what it is switched to."""
    key, *others = p.line.split()
    words = {"samples": f"{p.value} samples" if p.builder in OURS else f"{p.value}+{p.value}", "bins": f"{p.value} bins",
             "alpha": f"α {p.value}", "budget": f"{p.value} refs"}
    text = words.get(key, {"on": key, "off": f"no {key}"}.get(p.value, f"{key} {p.value}"))
    extra = {"subsample=off": ", all counted", "snap=on": ", snap"}
    return text + "".join(extra.get(e, f", {e}") for e in others)


def mark(axes, p, y, large):
    colour, marker = look(p.builder)
    size = (8 if p.usual else 4.5) if large else (6 if p.usual else 2.5)
    axes.plot(p.x, y, marker, ms=size, mfc=colour if p.usual else "white", mec=colour, mew=1.2,
              zorder=4 if p.usual else 3)


class Panel:
    """One panel: points, lines, fronts, labels. Points above the ceiling lie at it, with their figure."""

    def __init__(self, axes, found, further, ceiling, mixed):
        self.axes, self.found, self.further, self.ceiling, self.mixed = axes, found, further, ceiling, mixed
        self.labels = Labels(axes)

    def y(self, p):
        return min(p.y, self.ceiling)

    def draw_front(self):
        kinds = [(KD, BVH)] if self.mixed else [(KD,), (BVH,)]
        members = set()
        for marks in kinds:
            kept = front([p for p in self.found if look(p.builder)[1] in marks], self.further)
            members |= {p.text for p in kept}
            kept = [p for p in kept if p.y <= self.ceiling]
            self.axes.plot([p.x for p in kept], [p.y for p in kept], color="#bbbbbb", lw=5, alpha=0.55, zorder=1,
                           solid_capstyle="round", solid_joinstyle="round")
        return members

    def draw_points(self, large):
        for _, group in lines(self.found):
            colour = look(group[0].builder)[0]
            self.axes.plot([p.x for p in group], [self.y(p) for p in group], color=colour, lw=1.1 if large else 0.7,
                           alpha=0.8, zorder=2)
            for a, b in zip(group, group[1:]):
                self.labels.avoid_line((a.x, self.y(a)), (b.x, self.y(b)))
        for p in self.found:
            mark(self.axes, p, self.y(p), large)
            self.labels.avoid(p.x, self.y(p))

    def name(self, p, size):
        weight = "bold" if p.builder in OURS or p.usual and size > 8 else "normal"
        text = p.builder + (f" {p.y:.1f}x" if p.y > self.ceiling else "")
        self.labels.add(p.x, self.y(p), text, look(p.builder)[0], size, weight)

    def name_ends(self):
        """The first and the last value of every line."""
        for _, group in lines(self.found):
            for p in {group[0].text: group[0], group[-1].text: group[-1]}.values():
                if not p.usual and p.y <= self.ceiling:
                    self.labels.add(p.x, p.y, value_label(p), look(p.builder)[0], 6.5)


def panel(axes, found, view, large):
    further, ceiling, mixed = view["further"], view["ceiling"], view["mixed"]
    one = Panel(axes, found, further, ceiling, mixed)
    members = one.draw_front()
    one.draw_points(large)
    axes.axhline(1, color="#999999", lw=0.8, ls=(0, (3, 3)), zorder=0)
    for p in found:
        if p.usual and (large or p.text in members or p.builder in OURS):
            one.name(p, 9 if large else 7)
    if large and view["values"]:
        one.name_ends()
    axes.grid(color=LIGHT, lw=0.8, zorder=0)
    axes.set_axisbelow(True)
    return one


def limits(axes, found, ceiling):
    low, high = min(p.x for p in found), max(p.x for p in found)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(low / 1.5, high * 1.5)
    log_ticks(axes.xaxis, low / 1.5, high * 1.5)
    bottom = min(p.y for p in found) / 1.1
    top = min(max(p.y for p in found), ceiling) * 1.05
    axes.set_ylim(bottom, top)
    log_ticks(axes.yaxis, bottom, top, FINE if top / bottom < 5 else (1, 2, 5))


def draw_large(axes, found, view, scenes):
    """All scenes together, named and lettered."""
    limits(axes, found, view["ceiling"])
    axes.set_xlabel(view["x_label"])
    axes.set_ylabel(view["y_label"])
    if len(scenes) > 1:
        axes.set_title(f"geometric mean of {len(scenes)} scenes", fontsize=10, loc="left")
    right = view["further"] > 0
    axes.text(0.995 if right else 0.005, 0.012, view["hint"], transform=axes.transAxes, fontsize=9, color=GREY,
              style="italic", ha="right" if right else "left", va="bottom")
    return panel(axes, found, view, True)


def draw_scene(axes, data, mean, view, scene):
    found = points(data, mean, [scene], view["x"], view["y"])
    limits(axes, found, view["ceiling"])
    triangles = next(int(r["triangles"]) for r in data.of("build") if r["scene"] == scene)
    axes.set_title(f"{scene}, {triangles:,} triangles", fontsize=9, loc="left")
    axes.tick_params(labelsize=7)
    return panel(axes, found, view, False)


def legend(figure, found, view):
    marks = {look(p.builder)[1] for p in found}
    handles = [plt.Line2D([], [], color=BLACK, marker=m, ls="", ms=7, label=text)
               for m, text in ((KD, "kd-tree"), (BVH, "BVH"), (PEER, "Embree")) if m in marks]
    handles += [plt.Line2D([], [], color=GREY, marker="o", ls="", ms=7, label="filled: as it is by default"),
                plt.Line2D([], [], color=GREY, marker="o", mfc="white", ls="-", ms=4.5, label="one parameter varied"),
                plt.Line2D([], [], color="#bbbbbb", lw=5, alpha=0.55, label=view["front"])]
    figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.005, 0.02), ncol=len(handles), frameon=False,
                  fontsize=9)


def tradeoff(data, folder, mean, view):
    scenes = data.scenes()
    everything = points(data, mean, scenes, view["x"], view["y"])
    if not everything:
        return []
    rows = -(-len(scenes) // COLUMNS) if len(scenes) > 1 else 0
    figure = plt.figure(figsize=(13, 7.8 + 3.1 * rows))
    grid = figure.add_gridspec(1 + rows, COLUMNS, height_ratios=[7.6] + [3.1] * rows)
    panels = [draw_large(figure.add_subplot(grid[0, :]), everything, view, scenes)]
    for i, scene in enumerate(scenes if rows else []):
        axes = figure.add_subplot(grid[1 + i // COLUMNS, i % COLUMNS])
        panels.append(draw_scene(axes, data, mean, view, scene))
    figure.suptitle(view["title"], x=0.01, ha="left", fontsize=13)
    figure.tight_layout(rect=(0, 0.05, 1, 0.99))
    legend(figure, everything, view)
    figure.canvas.draw()
    for one in panels:
        one.labels.place()
    rays = next(int(r["count"]) for r in data.of("trace"))
    caption(figure, data, f"{rays:,} rays each overview, diffuse, random")
    return save(figure, folder, view["name"])


def cell(study, key):
    return lambda row: row.get(key) if row["study"] == study else None


def work(data, folder, mean):
    return tradeoff(data, folder, mean, {
        "name": "speed_accuracy_work", "x": cell("build", "mtris_per_s"), "y": cell("trace", "work_over_sweep"),
        "further": 1, "ceiling": 2.5, "mixed": False, "values": True, "x_label": "million triangles built a second",
        "y_label": "work a ray (steps + 1.5 tests) over the exact sweep's",
        "hint": "faster to build, less work: better",
        "front": "best of kd-trees, best of BVHs (a BVH's step tests two boxes)",
        "title": "What building faster costs the rays: work"})


def time(data, folder, mean):
    return tradeoff(data, folder, mean, {
        "name": "speed_accuracy_time", "x": cell("build", "mtris_per_s"), "y": cell("trace", "trace_over_sweep"),
        "further": 1, "ceiling": 2.5, "mixed": True, "values": False, "x_label": "million triangles built a second",
        "y_label": "time to trace over the exact sweep's",
        "hint": "faster to build, faster to trace: better", "front": "best of ours",
        "title": "What building faster costs the rays: time"})


def cost(data, folder, mean):
    scenes = {}
    for row in data.of("build"):
        if row["configuration"] == SWEEP:
            scenes[row["scene"]] = row["sah_cost"]

    def relative(row):
        known = row["study"] == "build" and "sah_cost" in row and row["scene"] in scenes
        return row["sah_cost"] / scenes[row["scene"]] if known else None

    def seconds(row):
        return 1e3 * row["build_ms"] / row["triangles"] if row["study"] == "build" else None

    return tradeoff(data, folder, mean, {
        "name": "speed_accuracy_cost", "x": seconds, "y": relative, "further": -1, "ceiling": 3, "mixed": False, "values": True,
        "x_label": "seconds to build a million triangles", "y_label": "SAH cost over the exact sweep's",
        "hint": "faster to build, cheaper tree: better",
        "front": "best of kd-trees, best of BVHs", "title": "What building time buys: expected cost"})


FIGURES = [work, time, cost]
