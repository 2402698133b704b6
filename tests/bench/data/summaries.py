"""The tables of the pages: short summaries of the CSV files, written between two marks of the page.

A page has a line `<!-- data: NAME -->`, then the table, then a line `<!-- end -->`. NAME is a function below.
"""
import math
import re

from csv_files import read_csv

BLOCK = re.compile(r"(<!-- data: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
KINDS = "overview", "diffuse", "random"
SWEEP = "sah-sweep?clip=off"
TURNED = "sponza turned"


def show(value):
    """A number as people read it: three digits, thousands apart; a text as it is."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    if value == 0:
        return "0"
    if abs(value) >= 1000:
        return f"{value:,.0f}"
    if float(value).is_integer():
        return f"{value:.0f}"
    return f"{value:.{max(0, 2 - math.floor(math.log10(abs(value))))}f}"


def percent(share):
    """A share of one in percent."""
    return "0" if share == 0 else f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def table(heads, lines):
    texts = [heads, ["---"] + ["---:"] * (len(heads) - 1), *([show(cell) for cell in line] for line in lines)]
    return "\n".join("| " + " | ".join(line) + " |" for line in texts)


def mean(values):
    """The geometric mean, or None if a value is missing."""
    values = list(values)
    return None if not values or None in values else math.exp(sum(map(math.log, values)) / len(values))


def groups(rows, *keys):
    """Rows by the values of these columns, in the order of the file."""
    found = {}
    for row in rows:
        found.setdefault(tuple(row.get(key) for key in keys), []).append(row)
    return {key if len(keys) > 1 else key[0]: of for key, of in found.items()}


# Builders.

def builder_line(name, rows, sweep):
    """One configuration: geometric means over the scenes of `rows`."""
    of_rays = lambda what: mean(row.get(f"{kind}_{what}") for row in rows for kind in KINDS)
    of_tree = lambda value: mean(None if "references" not in row else value(row) for row in rows)
    return [f"`{name}`", mean(row["mtris_per_s"] for row in rows), of_tree(lambda row: row["references"] / row["triangles"]),
            of_tree(lambda row: row["touches"] / row["triangles"]),
            of_tree(lambda row: row["sah_cost"] / sweep[row["scene"]]["sah_cost"]), of_rays("work_over_sweep"),
            of_rays("time_over_sweep")]


BUILDER_HEADS = ["builder", "Mtri/s", "references / triangle", "touches / triangle", "SAH cost", "work", "trace time"]


def builders(folder):
    rows = [row for row in read_csv(folder / "builders.csv") if row["scene"] != TURNED]
    sweep = {row["scene"]: row for row in rows if row["configuration"] == SWEEP}
    return table(BUILDER_HEADS, [builder_line(name, of, sweep) for name, of in groups(rows, "configuration").items()
                                 if of[0]["default"] == "yes" or of[0]["configuration"] == SWEEP])


def slivers(folder):
    return table(["builder", "build, ms", "references / triangle", "steps a ray", "tests a ray", "Mrays/s", "speed over Embree HIGH"],
                 [[f"`{row['configuration']}`", *(row.get(key) for key in ("build_ms", "references_per_triangle", "steps", "tests",
                                                                           "mrays_per_s", "speed_over_embree_high"))]
                  for row in read_csv(folder / "slivers.csv")])


TIMES = "seconds", "polygons_per_s"  # of machines of other decades: the page leaves them to the CSV file


def papers(folder):
    figure = lambda row: f"{row['quantity'].replace('_', ' ')}: {show(row['published'])} / {show(row['here'])}"
    figures = lambda rows: "; ".join(figure(row) for row in rows)
    rows = [row for row in read_csv(folder / "papers.csv") if row["quantity"] not in TIMES]
    return table(["source", "scene", "builder", "published / here"],
                 [[source, scene, f"`{builder}`", figures(of)]
                  for (source, scene, builder), of in groups(rows, "source", "scene", "builder").items()])


# Robustness.

def alike_once(lines):
    """Lines of a family, a method and cells: a method that has the same cells in every family has one line, of all."""
    families = len({line[0] for line in lines})
    cells_of = {}
    for _, method, *cells in lines:
        cells_of.setdefault(method, []).append(cells)
    alike = {method: cells[0] for method, cells in cells_of.items() if cells.count(cells[0]) == len(cells) == families}
    return [["all", method, *cells] for method, cells in alike.items()] + \
        [line for line in lines if line[1] not in alike]


def robust(folder):
    lines = []
    rows = [row for row in read_csv(folder / "robust.csv") if row["builder"] == "scan-fast" or row["method"] != "exact"]
    for (family, policy, method), of in groups(rows, "family", "policy", "method").items():
        kinds = {kind: [sum(row[key] for row in some) for key in ("missed", "extra", "rays")] for kind, some in groups(of, "kind").items()}
        cell = lambda missed, extra, rays: "0" if missed + extra == 0 else f"{percent(missed / rays)}, {percent(extra / rays)}"
        checked, wrong = (sum(row.get(key, 0) for row in of) for key in ("checked", "mismatched"))
        cells = [*(cell(*kinds[kind]) for kind in ("vertices", "edges", "random", "axis")), percent(wrong / checked) if checked else None]
        if policy == "first-touch" and lines[-1][0] == family and lines[-1][2:] == cells:
            lines[-1][1] += ", full and growing"
        else:
            lines.append([family, method + (", growing" if policy == "first-touch" else ""), *cells])
    return table(["family", "method", "vertices", "edges", "random", "axis", "wrong nearest hit"], alike_once(lines))


def broken(text):
    """The bounds that a row names: `references 18.2 over 16: why; depth ...`."""
    return [part.strip() for part in text.split(";") if part.strip()]


def stability(folder):
    """Each builder over all families. No builder may have a wrong answer, so these are counted among the failures."""
    lines = []
    for name, rows in groups(read_csv(folder / "stability.csv"), "builder").items():
        design = [row["family"] for row in rows if row.get("failed_by_design")]
        failures = [f"{row['family']}: {part}" for row in rows for part in broken(row.get("failures", ""))]
        wrong = [f"{row['family']}: {show(row['wrong'])} wrong answers" for row in rows if row["wrong"]]
        works = [row["relative_work"] for row in rows if row.get("relative_work")]
        lines.append([f"`{name}`", len(rows) - len(design) - len(failures), ", ".join(design) or "none",
                      ", ".join(failures + wrong) or "none", mean(works), max(works, default=None)])
    return table(["builder", f"of {len(rows)} families keep all bounds", "broken by design of the method", "failures",
                  "work over the sweep, mean", "worst"], lines)


HARD = "slivers", "rods", "fan", "book", "stacks", "turned-halls", "nested", "stadium", "far-1e7"


def hard_families(folder):
    rows = {(row["family"], row["builder"]): row for row in read_csv(folder / "stability.csv")}
    keys = "references_per_triangle", "touches_per_triangle", "relative_work"
    return table(["family", *(f"`{builder}` {what}" for builder in ("scan-fast", "scan-best") for what in ("references", "touches", "work"))],
                 [[family, *(rows[family, builder].get(key) for builder in ("scan-fast", "scan-best") for key in keys)] for family in HARD])


def clusters(folder):
    sizes = groups(read_csv(folder / "clusters.csv"), "triangles")
    rows = {(row["kind"], size): row for size, of in sizes.items() for row in of}
    kinds = dict.fromkeys(kind for kind, _ in rows)
    keys = ("final", "final"), ("peak, full", "peak_full"), ("peak, growing", "peak_growing"), ("work", "relative_work")
    return table(["kind", *(f"{size:,.0f}: {name}" if i == 0 else name for size in sizes for i, (name, _) in enumerate(keys))],
                 [[kind, *(rows[kind, size].get(key) for size in sizes for _, key in keys)] for kind in kinds])


def exactness(folder):
    return table(["scene", *KINDS],
                 [[scene, *(f"{row['exact_over_float']:.2f} ({row['product_over_float']:.2f})" for row in of)]
                  for scene, of in groups(read_csv(folder / "exactness.csv"), "scene").items()])


# Lazy growth and motion.

def law(folder):
    rows = read_csv(folder / "lazy_law.csv")
    sparse = groups((row for row in rows if row["what"] == "sparse"), "hierarchy")
    return table(["references", "a", "b", "R^2", "largest residual", "few scattered rays", "many scattered rays"],
                 [[row["hierarchy"], row["a"], row["b"], f"{row['r_squared']:.3f}", row["max_residual"],
                   sparse[row["hierarchy"]][0]["over_n_log_cells"], sparse[row["hierarchy"]][-1]["over_n_log_cells"]]
                  for row in rows if row["what"] == "fit"])


def villages(folder):
    return table(["triangles", "nodes", "touches", "touches of the first ray", "first hit, us", "with cold caches, us"],
                 [[f"2^{math.log2(row['triangles']):.0f}", *(row[key] for key in ("nodes", "touches", "touches_first", "first_hit_us",
                                                                                  "first_hit_cold_us"))]
                  for row in read_csv(folder / "villages.csv")])


def lazy_times(folder):
    lines = []
    for (scene, rays, count), of in groups(read_csv(folder / "lazy_times.csv"), "scene", "rays", "count").items():
        mode = {row["mode"]: row for row in of}
        over = lambda name: mode.get(name, {}).get("lazy_over_this")
        lines.append([scene, f"{count:,.0f} {rays}", percent(mode["lazy"]["visible_fraction"]), 1e3 * mode["lazy"]["seconds_to_hits"],
                      over("full"), over("embree-low"), over("embree-lazy")])
    return table(["scene", "rays", "visible", "lazy, ms", "lazy / full", "lazy / Embree LOW", "lazy / Embree lazy"], lines)


def kernel(folder):
    lines = []
    for name, of in groups(read_csv(folder / "kernel.csv"), "pass").items():
        near, far = of[0], of[-1]
        lines.append([name, f"{near['planes']:.0f} x {near['axes']:.0f}", near["mboxes_per_s"], far["mboxes_per_s"]])
    return table(["pass", "planes x axes", "M boxes/s from L2", "from memory"], lines)


ASIDE = "again_", "dynamic_touches", "small_", "static_trace_ms"  # columns that the page leaves to the CSV file


def motion(folder):
    rows = [row for row in read_csv(folder / "motion.csv") if not row["quantity"].startswith(ASIDE)]
    figures = lambda of: "; ".join(f"{row['quantity'].replace('_', ' ')}: {show(row['figure'])}" for row in of
                                   if not row["quantity"].endswith(("_q1", "_q3")))
    return table(["show", "figures"], [[name, figures(of)] for name, of in groups(rows, "show").items()])


def filled(text, folder):
    """The page with the tables that the CSV files give."""
    return BLOCK.sub(lambda match: f"{match[1]}{globals()[match[2]](folder)}\n{match[3]}", text)


def pages(root):
    return [path for path in sorted(root.glob("docs/*.md")) if BLOCK.search(path.read_text())]


def fill(root, folder):
    for page in pages(root):
        page.write_text(filled(page.read_text(), folder))


def outdated(root, folder):
    """Pages whose tables differ from the CSV files."""
    return [page.relative_to(root).as_posix() for page in pages(root) if filled(page.read_text(), folder) != page.read_text()]
