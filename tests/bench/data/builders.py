"""Parts about builders: trees, work and time on real scenes, growth of touches, slivers, and the papers' figures."""
import csv
import math
import pathlib
import tempfile

KINDS = "overview", "diffuse", "random"
TREE = "sah_cost", "nodes", "references", "max_depth", "overlap", "bytes", "touches"
TURNED = "45,45,45"


def number(text):
    return None if text in (None, "") else int(text) if text.isdigit() else float(text)


def study(bench, options, *more):
    """The rows of `sightline-bench chart`, which builds and traces every configuration in turns."""
    with tempfile.TemporaryDirectory() as folder:
        bench.run("chart", "--out", folder, "--threads", 1, "--repeat", options.repeat, *more)
        with open(pathlib.Path(folder) / "speed_accuracy.csv", newline="") as file:
            rows = list(csv.DictReader(file))
    bench.commands[-1] = bench.commands[-1].replace(folder, "DIR")
    return rows


def builder_rows(rows, name=None):
    """One row a scene and configuration: what was measured of the build, and of the rays of each kind."""
    found = {}
    for row in rows:
        if row["study"] not in ("build", "trace"):
            continue
        key = row["scene"], row["configuration"]
        one = found.setdefault(key, {"scene": name or row["scene"], "triangles": int(row["triangles"]),
                                     "builder": row["builder"], "configuration": row["configuration"], "line": row["line"],
                                     "value": row["value"], "default": row["usual"] == "1"})
        if row["study"] == "build":
            one["build_ms"], one["mtris_per_s"] = number(row["build_ms"]), number(row["mtris_per_s"])
            one.update({key: number(row[key]) for key in TREE})
        else:
            kind = row["rays"]
            for column, key in (("steps", "steps_per_ray"), ("tests", "tests_per_ray"), ("work_over_sweep",) * 2,
                                ("time_over_sweep", "trace_over_sweep"), ("mrays_per_s",) * 2):
                one[f"{kind}_{column}"] = number(row[key])
    return list(found.values())


def image_rows(rows):
    return [{"scene": row["scene"], "builder": row["builder"], "policy": row["policy"], "rays": row["rays"],
             "count": int(row["count"]), "basis": row["basis"], "seconds_to_hits": float(row["seconds_to_hits"])}
            for row in rows if row["study"] == "image"]


def builders(bench, options):
    rows = study(bench, options)
    turned = study(bench, options, "--rotate", TURNED, "--scenes", "{sponza}")
    return {"builders": builder_rows(rows) + builder_rows(turned, "sponza turned"), "images": image_rows(rows)}


# Builder, the law that its paper states, and the sizes: 2^low to 2^high triangles.
LAWS = {"N log N": lambda n: n * math.log2(n), "N log^2 N": lambda n: n * math.log2(n) ** 2}
GROWTH = [("sah-sort", "N log^2 N", 12, 16), *((name, "N log N", 12, 18) for name in
          ("sah-sweep", "min-max-bins", "scan-one-axis", "scan-all-axes", "scan-fast", "scan-best"))]


def fit(points, law):
    """a of touches = a law(n), fitted with relative errors, and the largest |a law(n) / touches - 1|."""
    shares = [law(n) / touches for n, touches in points]
    a = sum(shares) / sum(s * s for s in shares)
    return a, max(abs(a * s - 1) for s in shares)


def growth(bench, options):
    points = {name: [] for name, *_ in GROWTH}
    for power in range(12, 19):
        names = [name for name, _, low, high in GROWTH if low <= power <= high]
        rows = bench.by("builder", "build", "--scene", f"gen:terrain?triangles={2 ** power}", "--builder", ",".join(names),
                        "--threads", 1, "--repeat", 1)
        for name in names:
            points[name].append((2 ** power, rows[name]["touches"]))
    table = []
    for name, law, *_ in GROWTH:
        a, residual = fit(points[name], LAWS[law])
        table += [{"builder": name, "triangles": n, "touches": touches, "touches_per_triangle": touches / n, "law": law,
                   "a": a, "largest_residual": residual} for n, touches in points[name]]
    return {"growth": table}


SLIVERS = ["bvh-sweep", "bvh-esc?split_small=on&budget=8", "bvh-esc?split_small=on&budget=32", "sbvh", "scan-fast",
           "scan-best?budget=4", "scan-best?budget=8", "scan-best", "scan-best?budget=32", "sah-sweep", "embree-high"]


def slivers(bench, options):
    where = "--scene", "gen:slivers?triangles=30000", "--builder", ",".join(SLIVERS), "--threads", 1
    built = bench.by("builder", "build", *where, "--repeat", 1)
    traced = bench.by("builder", "trace", *where, "--rays", "random", "--count", 3000, "--repeat", options.repeat)
    best = traced.get("embree-high", {}).get("trace_ms")
    table = []
    for name in (name for name in SLIVERS if name in built):
        tree, rays = built[name], traced[name]
        row = {"configuration": name, "build_ms": tree["build_ms"]}
        if "references" in tree:
            row["references_per_triangle"] = tree["references"] / tree["triangles"]
            row["steps"] = rays["traversal_steps"] / rays["count"]
            row["tests"] = rays["triangle_tests"] / rays["count"]
        row["mrays_per_s"] = rays["mrays_per_s"]
        row["speed_over_embree_high"] = best / rays["trace_ms"] if best else None
        table.append(row)
    return {"slivers": table}


# Published figures, as they are printed: scene, builder, quantity, figure.
HUNT = "Hunt, Mark, Stoll 2006, Table 1", [
    ("bunny", "scan-all-axes", "polygons_per_s", 278_000), ("bunny", "scan-hybrid", "polygons_per_s", 302_000),
    ("bunny", "scan-one-axis", "polygons_per_s", 631_000), ("fairy_forest", "scan-all-axes", "polygons_per_s", 320_000),
    ("fairy_forest", "scan-hybrid", "polygons_per_s", 355_000), ("fairy_forest", "scan-one-axis", "polygons_per_s", 685_000),
    ("bunny", "scan-all-axes", "cost_1_to_1", 76.0), ("bunny", "scan-hybrid", "cost_1_to_1", 76.0),
    ("bunny", "scan-one-axis", "cost_1_to_1", 95.0), ("fairy_forest", "scan-all-axes", "cost_1_to_1", 53.6),
    ("fairy_forest", "scan-hybrid", "cost_1_to_1", 59.6), ("fairy_forest", "scan-one-axis", "cost_1_to_1", 69.0)]
WALD_HAVRAN = "Wald, Havran 2006, Table 2", [
    (scene, "sah-sweep?lambda=1", quantity, figure) for scene, figures in
    {"bunny": (349_000, 183_000, 2.50, 52.3, 14.7, 7.1), "dragon": (1_410_000, 812_000, 2.64, 76.7, 20.8, 8.4)}.items()
    for quantity, figure in zip(("leaves", "nonempty_leaves", "references_per_leaf", "expected_traversals", "expected_leaves",
                                 "expected_intersections"), figures)]
SECONDS = [
    ("Wald, Havran 2006, Table 1", [("bunny", "sah-sweep", "seconds", 4.8), ("dragon", "sah-sweep", "seconds", 23.9)]),
    ("survey, section 7.1", [("bunny", "min-max-bins", "seconds", 0.104), ("dragon", "min-max-bins", "seconds", 0.751)])]
# References, cost and overlap of sbvh over bvh-sweep's.
STICH = "Stich, Friedrich, Dietrich 2009, Table 1", [
    ("conference", "sbvh", "references_over_sweep", 1.25), ("conference", "sbvh", "cost_over_sweep", 60.6 / 73.2),
    ("conference", "sbvh", "overlap_over_sweep", 0.73), ("sibenik", "sbvh", "references_over_sweep", 1.28),
    ("sibenik", "sbvh", "cost_over_sweep", 75.4 / 86.1), ("sibenik", "sbvh", "overlap_over_sweep", 0.76),
    ("sponza turned", "sbvh", "references_over_sweep", 2.03), ("sponza turned", "sbvh", "overlap_over_sweep", 0.57)]
PUBLISHED = [HUNT, WALD_HAVRAN, *SECONDS, STICH]
TURN = {"sponza turned": ("{sponza}", "--merge", "--rotate", TURNED)}


def quantities(row, sweep):
    """What the papers' tables hold, of one build; relative figures are over bvh-sweep's."""
    found = {"polygons_per_s": row["mtris_per_s"] * 1e6, "seconds": row["build_ms"] / 1e3,
             "cost_1_to_1": row["expected_traversals"] + row["expected_intersections"],
             "references_per_leaf": row["references"] / row["nonempty_leaves"],
             **{key: row[key] for key in ("leaves", "nonempty_leaves", "expected_traversals", "expected_leaves",
                                          "expected_intersections")}}
    if sweep:
        found |= {"references_over_sweep": row["references"] / sweep["references"],
                  "cost_over_sweep": row["sah_cost"] / sweep["sah_cost"], "overlap_over_sweep": row["overlap"] / sweep["overlap"]}
    return found


def papers(bench, options):
    wanted = {}  # builders by scene
    for _, figures in PUBLISHED:
        for scene, builder, *_ in figures:
            wanted.setdefault(scene, set()).update({builder} | ({"bvh-sweep"} if builder == "sbvh" else set()))
    built = {scene: bench.by("builder", "build", "--scene", *TURN.get(scene, [f"{{{scene}}}"]), "--builder",
                             ",".join(sorted(names)), "--threads", 1, "--repeat", 1) for scene, names in wanted.items()}
    return {"papers": [{"source": source, "scene": scene, "builder": builder, "quantity": quantity, "published": float(figure),
                        "here": float(quantities(built[scene][builder], built[scene].get("bvh-sweep"))[quantity])}
                       for source, figures in PUBLISHED for scene, builder, quantity, figure in figures]}


def scan_approximation(bench, options):
    # The bonus for empty sides would make both curves jump at the faces of the cell and nowhere else.
    rows = bench.rows("curve", "--scene", "gen:wall?triangles=10000&share=0.5&at=0.62", "--points", 300, "--set", "empty_bonus=1")
    return {"scan_approximation": [{"what": row["what"], **{key: f"{row[key]:.8g}" for key in ("position", "left", "right", "cost")}}
                                   for row in rows]}
