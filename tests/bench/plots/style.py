"""How all charts look: colours, marks, labels that do not overlap, captions; and how a chart is saved."""
import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
from matplotlib.transforms import Bbox

# Colours that colour-blind readers can tell apart (Okabe and Ito's, and a dark red for Embree).
GREY, BLACK, ORANGE, SKY, BLUE = "#777777", "#222222", "#d98c00", "#56b4e9", "#0072b2"
GREEN, PURPLE, RED, WINE = "#009e73", "#cc79a7", "#d55e00", "#882255"
KD, BVH, PEER = "o", "s", "D"
BUILDERS = {"spatial-median": (GREY, KD), "object-median": (GREY, KD), "sah-sweep": (BLACK, KD),
            "min-max-bins": (ORANGE, KD), "scan-one-axis": (SKY, KD), "scan-hybrid": (SKY, KD),
            "scan-all-axes": (SKY, KD), "scan-fast": (BLUE, KD), "scan-best": (BLUE, KD),
            "bvh-sweep": (GREEN, BVH), "bvh-binned": (GREEN, BVH), "bvh-esc": (PURPLE, BVH), "bvh-evh": (PURPLE, BVH),
            "sbvh": (RED, BVH), "embree-low": (WINE, PEER), "embree-medium": (WINE, PEER), "embree-high": (WINE, PEER)}
OURS = "scan-fast", "scan-best"
LIGHT = "#eeeeee"
LARGEST_SVG = 300_000  # bytes

plt.rcParams.update({"svg.hashsalt": "sightline", "font.size": 10, "axes.spines.top": False,
                     "axes.spines.right": False})


def look(builder):
    """Colour and mark of a builder; of one that is new: grey."""
    return BUILDERS.get(builder, (GREY, KD))


def number(value):
    """As people read it."""
    if value >= 1e6 or value < 1e-4:
        return f"{value:.0e}".replace("e+0", "e").replace("e-0", "e-")
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def log_ticks(axis, low, high, steps=(1, 2, 5)):
    """Round numbers from low to high, written out."""
    ticks = [m * 10.0 ** e for e in range(-7, 9) for m in steps if low <= m * 10.0 ** e <= high]
    axis.set_ticks(ticks, [number(t) for t in ticks])
    axis.set_ticks([], minor=True)


class Labels:
    """Puts texts beside points of one panel, clear of each other, of all points and of the panel's edges."""
    # Directions in the order of liking, as (x, y) of the text's box relative to the point.
    AROUND = [(1, 0.5), (1, 1), (-1, 0.5), (1, -1), (-1, 1), (-1, -1), (0, 1), (0, -1), (1, -0.5), (-1, -0.5)]

    def __init__(self, axes):
        self.axes, self.points, self.segments, self.wanted = axes, [], [], []

    def avoid(self, x, y):
        self.points.append((x, y))

    def avoid_line(self, a, b):
        self.segments.append((a, b))

    def add(self, x, y, text, colour, size=8, weight="normal"):
        self.wanted.append((x, y, text, colour, size, weight))

    def place(self):
        """After everything is drawn and limits are set; bold ones first."""
        figure = self.axes.figure
        renderer = figure.canvas.get_renderer() if hasattr(figure.canvas, "get_renderer") else figure._get_renderer()
        self.scale = figure.dpi / 72
        self.window = self.axes.get_window_extent(renderer)
        to_dots = self.axes.transData.transform
        self.dots = [to_dots(p) for p in self.points]
        self.beads = [bead for a, b in self.segments for bead in self.string(to_dots(a), to_dots(b))]
        self.taken = []
        for x, y, text, colour, size, weight in sorted(self.wanted, key=lambda w: w[5] != "bold"):
            probe = self.axes.text(0, 0, text, fontsize=size, fontweight=weight)
            box = probe.get_window_extent(renderer)
            probe.remove()
            at = to_dots((x, y))
            here, far = min(self.places(at, box), key=lambda place: self.cost(*place))
            self.taken.append(here)
            self.write(at, here, text, colour, size, weight, far > 12)

    @staticmethod
    def string(a, b):
        count = max(2, int(max(abs(b[0] - a[0]), abs(b[1] - a[1])) / 6))
        return [(a[0] + (b[0] - a[0]) * i / count, a[1] + (b[1] - a[1]) * i / count) for i in range(count + 1)]

    def places(self, at, box):
        """Where the text's box may lie, nearest and best liked first, and how far off that is."""
        for far in (6, 10, 15, 22, 30, 40, 52, 66, 84):
            for k, (dx, dy) in enumerate(self.AROUND):
                reach = far * self.scale
                left = at[0] + dx * reach - (0 if dx > 0 else box.width if dx < 0 else box.width / 2)
                low = at[1] + dy * reach - box.height / 2 + (0 if abs(dy) < 1 else dy * box.height / 4)
                yield Bbox.from_bounds(left, low, box.width, box.height), far + 0.5 * k

    def cost(self, here, far):
        margin = 2 * self.scale
        inside = lambda dot: here.x0 - margin < dot[0] < here.x1 + margin and here.y0 - margin < dot[1] < here.y1 + margin
        window = self.window
        outside = (max(0, window.x0 - here.x0) + max(0, here.x1 - window.x1) + max(0, window.y0 - here.y0) +
                   max(0, here.y1 - window.y1))
        return (far + 1000 * sum(map(here.overlaps, self.taken)) + 60 * sum(map(inside, self.dots)) +
                3 * sum(map(inside, self.beads)) + 50 * outside)

    def write(self, at, here, text, colour, size, weight, leader):
        inverse = self.axes.transData.inverted()
        middle = ((here.x0 + here.x1) / 2, (here.y0 + here.y1) / 2)
        if leader:
            edge = min(max(at[0], here.x0), here.x1), min(max(at[1], here.y0), here.y1)
            self.axes.plot(*zip(inverse.transform(at), inverse.transform(edge)), color=colour, lw=0.6, alpha=0.6, zorder=2)
        self.axes.text(*inverse.transform(middle), text, fontsize=size, fontweight=weight, color=colour, ha="center",
                       va="center", zorder=6)


def caption(figure, run, more):
    """Machine, compiler, commit and date of the measurement, below everything."""
    rounds = f"medians of {run['repeat']} rounds" if run["repeat"] > 1 else "one round"
    text = f"{run['machine']}, one thread · {run['compiler']} · commit {run['commit']} · {run['date']} · {rounds} · {more}"
    figure.text(0.01, 0.008, text, fontsize=8, color="#555555", ha="left", va="bottom")


def save(figure, folder, name):
    """As SVG, or as PNG if the SVG is larger than LARGEST_SVG. Returns the path."""
    svg, png = folder / f"{name}.svg", folder / f"{name}.png"
    figure.savefig(svg, metadata={"Date": None})
    if svg.stat().st_size > LARGEST_SVG:
        svg.unlink()
        figure.savefig(png, dpi=75)
    else:
        png.unlink(missing_ok=True)
    plt.close(figure)
    return png if png.exists() else svg
