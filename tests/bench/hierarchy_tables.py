"""The tables of hierarchies: paper 003's Table 1 beside ours, and what splitting gives on slivers."""
from bench_runs import print_table

# As printed: references %, nodes, SAH cost, intersections, traversals, overlap %, speed % of primary and of occlusion rays.
PAPER = {
    "conference": {"bvh-sweep": (100, 98_703, 73.2, 63.0, 117.1, 100, 100, 100), "sbvh": (125, 124_805, 60.6, 43.2, 98.7, 73, 122, 125),
                   "bvh-esc": (125, 124_633, 97.6, 35.7, 126.0, 97, 87, 103), "bvh-evh": (125, 124_129, 67.3, 48.5, 109.5, 101, 104, 102)},
    "sibenik": {"bvh-sweep": (100, 26_993, 86.1, 42.3, 122.6, 100, 100, 100), "sbvh": (128, 35_079, 75.4, 38.9, 109.0, 76, 116, 113),
                "bvh-esc": (128, 35_125, 94.1, 40.9, 127.1, 103, 94, 96), "bvh-evh": (128, 35_369, 93.7, 39.9, 126.9, 125, 95, 94)},
    # The print is damaged: what can be read with certainty.
    "sponza turned": {"bvh-sweep": (100, None, 123.5, None, None, 100, 100, 100), "sbvh": (203, None, None, None, None, 57, 215, 174),
                      "bvh-esc": (205, None, 172, None, None, 110, 139, 114), "bvh-evh": (205, None, 130.4, None, None, 114, 141, 107)},
}
SCENES = {"conference": ["conference"], "sibenik": ["sibenik"], "sponza turned": ["sponza", "--merge", "--rotate", "45,45,45"],
          "fairy_forest": ["fairy_forest"]}
METHODS = ["bvh-sweep", "sbvh", "bvh-esc", "bvh-evh", "bvh-esc, named once", "bvh-evh, named once"]
RAYS = ["overview", "diffuse", "random"]


def builds(bench, where, builders, repeat, *more):
    """A row a builder, by its name."""
    rows = bench.rows("build", "--scene", *where, "--builder", ",".join(builders), "--threads", 2, "--repeat", repeat, *more)
    return {row["builder"]: row for row in rows}


def at_equal_references(bench, where, method, wanted):
    """The method with the budget that gives a tree of so many references. What a leaf would name twice is named once, so the
    budget is larger than that."""
    low, high = 1.0, 64.0
    for _ in range(12):
        budget = round((low * high) ** 0.5, 3)
        name = f"{method}?budget={budget}"
        references = builds(bench, where, [name], 1)[name]["references"]
        if abs(references - wanted) <= 0.005 * wanted:
            break
        low, high = (budget, high) if references < wanted else (low, budget)
    return name


def table_1(bench, options):
    heads = ["method", "", "references", "nodes", "SAH cost", "overlap", "end-point overlap",
             *(f"{kind} {what}" for kind in RAYS for what in ("tests", "steps", "speed")), "build ms", "Mtri/s"]
    for title, where in SCENES.items():
        first = builds(bench, where, ["sbvh"], 1)["sbvh"]
        names = {"bvh-sweep": "bvh-sweep", "sbvh": "sbvh"}
        for method in METHODS[2:4]:
            names[method] = f"{method}?repeats=on&budget={first['references'] / first['triangles']:.4f}"
            names[method + ", named once"] = at_equal_references(bench, where, method, first["references"])
        small = ["bvh-binned", "bvh-sweep?split_small=on", "sbvh?split_small=on"]
        others = small + ["scan-fast", "sah-sweep", "embree-high", "embree-medium"]
        built = builds(bench, where, [*names.values(), *others], options.repeat, "--end-points")
        traced = {kind: {row["builder"]: row for row in bench.rows(
            "trace", "--scene", *where, "--builder", ",".join([*names.values(), *small, "scan-fast", "sah-sweep", "embree-high"]), "--rays", kind,
            "--count", options.count, "--threads", 1, "--repeat", options.repeat)} for kind in RAYS}
        base = built["bvh-sweep"]
        lines = []
        for method in [*METHODS, *others]:
            if method in PAPER.get(title, {}):
                references, nodes, cost, tests, steps, overlap, primary, occlusion = PAPER[title][method]
                lines.append([method, "paper", f"{references} %", nodes, cost, f"{overlap} %", None,
                              tests, steps, f"{primary} %", None, None, f"{occlusion} %", None, None, None, None, None])
            name = names.get(method, method)
            if name not in built:
                continue
            row, line = built[name], [method, "here" if method in METHODS else ""]
            if "sah_cost" in row:
                line += [f"{100 * row['references'] / row['triangles']:.0f} %", row["nodes"], row["sah_cost"],
                         f"{100 * row['overlap'] / base['overlap']:.0f} %" if row["overlap"] else None, row.get("end_point_overlap")]
            else:
                line += [None] * 5
            for kind in RAYS:
                ray = traced[kind].get(name)
                if ray is None:
                    line += [None] * 3
                    continue
                line += [ray["triangle_tests"] / ray["count"] if "triangle_tests" in ray else None,
                         ray["traversal_steps"] / ray["count"] if "traversal_steps" in ray else None,
                         f"{100 * traced[kind]['bvh-sweep']['trace_ms_min'] / ray['trace_ms_min']:.0f} %"]
            lines.append(line + [row["build_ms_min"], row["mtris_per_s"]])
        print_table(f"{title}, {base['triangles']:,} triangles", heads, lines)


def slivers(bench, options):
    where = ["gen:slivers?triangles=100000"]
    budgets = (1, 2, 4, 8, 16, 32, 64)
    builders = ["bvh-sweep", *(f"bvh-esc?split_small=on&budget={b}" for b in budgets), *(f"bvh-evh?split_small=on&budget={b}" for b in (2, 8, 32)),
                *(f"sbvh?alpha=0&split_small=on&budget={b}" for b in (1, 7, 63)), "scan-fast", "scan-best", "sah-sweep?clip=off", "sah-sweep",
                "embree-high"]
    built = {row["builder"]: row for row in bench.rows("build", "--scene", *where, "--builder", ",".join(builders), "--threads", 2, "--repeat", 1)}
    lines = []
    traced = {kind: {row["builder"]: row for row in bench.rows(
        "trace", "--scene", *where, "--builder", ",".join(builders), "--rays", kind, "--count", 2_000, "--threads", 1, "--repeat", 2)}
        for kind in ("overview", "random")}
    for name in builders:
        if name not in built:
            continue
        row = built[name]
        line = [name, row["references"] / row["triangles"] if "references" in row else None]
        for kind in traced:
            ray = traced[kind][name]
            line += [ray["traversal_steps"] / ray["count"] if "traversal_steps" in ray else None,
                     ray["triangle_tests"] / ray["count"] if "triangle_tests" in ray else None, ray["mrays_per_s"]]
            high = traced[kind].get("embree-high")
            line.append(high["trace_ms_min"] / ray["trace_ms_min"] if high else None)
        lines.append(line + [row["build_ms_min"]])
    print_table("slivers, 100,000 long thin triangles", ["builder", "references / triangle",
                *(f"{kind} {what}" for kind in traced for what in ("steps", "tests", "Mrays/s", "over Embree HIGH")), "build ms"], lines)


def print_all(bench, options):
    table_1(bench, options)
    slivers(bench, options)
