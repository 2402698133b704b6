"""The tables of "Lazy" in docs/benchmarks.md."""
import math
import os

from bench_runs import print_table, show

PEERS = "lazy,full,embree-low,embree-medium"
SCENES = [("dragon", "dragon"), ("sponza", "sponza"), ("torcs_forza", "torcs_forza"),
          ("city, 2 M", "gen:city?triangles=2000000"), ("terrain, 4 M", "gen:terrain?triangles=4000000")]
OBJECTS = [("city, 400 objects", "gen:city?boxes=20000"), ("herd, 100 bunnies", "gen:herd?copies=100&mesh=bunny")]
UNORDERED = [("bunny", "bunny"), ("dragon, faces shuffled", "gen:shuffled?mesh=dragon")]
SIZES = [14, 18, 22]  # shown of those measured


def percent(share):
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def power(n):
    return f"2^{round(math.log2(n))}"


def law(bench, options):
    rows = bench.rows("law", "--threads", 2)
    fits = [r for r in rows if r["what"] == "fit"]
    print_table("touches = a n + b m log2 m on gen:terrain, n = 2^14 to 2^22, m/n = 2^-10 to 1",
                ["hierarchy", "a", "b", "R²", "R² of logarithms", "largest residual", "points"],
                [[f["hierarchy"], f["a"], f["b"], f"{f['r_squared']:.4f}", f"{f['r_squared_log']:.4f}", f["max_residual"],
                  f["points"]] for f in fits])
    table = []
    shares = sorted({r["share"] for r in rows if r["what"] == "point"})
    for fit in fits:
        for n in SIZES:
            line = {r["share"]: r["touches"] / r["n"] for r in rows
                    if r["what"] == "point" and r["hierarchy"] == fit["hierarchy"] and r["n"] == 2 ** n}
            if line:
                table.append([f"{fit['hierarchy']}, 2^{n}"] + [line[s] for s in shares])
    print_table("Touches over n; columns are the windows' share of the scene", ["n"] + [power(s) if s < 1 else "1" for s in shares],
                table)
    sparse = [r for r in rows if r["what"] == "sparse"]
    counts = sorted({r["rays"] for r in sparse})
    print_table(f"Rays scattered over all of it, n = {power(sparse[0]['n'])}: touches / (n log2(1 + cells))",
                ["hierarchy"] + [f"{c:,} rays" for c in counts],
                [[f["hierarchy"]] + [r["over_n_log_cells"] for c in counts for r in sparse
                                     if r["hierarchy"] == f["hierarchy"] and r["rays"] == c] for f in fits])


def unordered(bench, options):
    table = []
    for title, scene in UNORDERED:
        rows = bench.rows("law", "--scene", scene, "--threads", 2)
        points = [r for r in rows if r["what"] == "point" and "over_soup" in r]
        worst = next(r for r in rows if r["what"] == "worst")
        table.append([title, worst["over_soup"], min(p["over_soup"] for p in points), points[-1]["over_soup"], worst["over_soup_in_all"]])
    print_table("Touches with runs over the soup's, windows of 2^-10 to 1 of the scene",
                ["scene", "worst", "best", "seen whole", "worst, making boxes included"], table)


def nodes(bench, options):
    rows = bench.rows("law", "--nodes", "--threads", 1, "--repeat", options.repeat)
    print_table("One view of ever larger villages",
                ["triangles", "nodes", "touches", "boxes made", "µs to the first hit", "with cold caches"],
                [[power(r["triangles"]), r["nodes"], r["touches"], r["touches_prepare"], r["first_hit_us"], r["first_hit_cold_us"]]
                 for r in rows if r["what"] == "point"] +
                [[f"growth over {show(r['triangles_growth'])}x", "", r["touches_growth"], r["touches_prepare_growth"],
                  r["first_hit_us_growth"],
                   r["first_hit_cold_us_growth"]] for r in rows if r["what"] == "growth"])


def timed(bench, options, scene, rays, count, modes):
    rows = bench.rows("lazy", "--scene", scene, "--rays", rays, "--count", count, "--modes", modes, "--threads", 1,
                      "--repeat", options.repeat)
    rows = {r["mode"]: r for r in rows}
    for row in rows.values():
        if row.get("unexplained"):
            raise SystemExit(f"tables: {scene}: {row['mode']} has {row['unexplained']} answers that nothing explains")
    return rows


def times(bench, options):
    table = []
    for title, scene in SCENES:
        rows = timed(bench, options, scene, "closeup", 10_000, PEERS)
        lazy = rows["lazy"]
        ms = [1e3 * rows[mode]["seconds_to_hits"] if mode in rows else None for mode in PEERS.split(",")]
        table.append([title, percent(lazy["visible_fraction"]), percent(lazy["touches"] / rows["full"]["touches"]), *ms,
                      lazy["over_full"], lazy.get("over_embree_low")])
    print_table("From arrays to 10,000 hits of a close-up, one thread, ms",
                ["scene", "visible", "touches of full", "lazy", "full", "Embree LOW", "Embree MEDIUM", "lazy / full", "lazy / LOW"], table)
    table = []
    for title, scene in SCENES:
        rows = timed(bench, options, scene, "random", 1_000_000, "lazy,full")
        table.append([title, percent(rows["lazy"]["visible_fraction"]), *[rows[m]["seconds_to_hits"] for m in ("lazy", "full")],
                      rows["lazy"]["over_full"]])
    print_table("From arrays to 1,000,000 hits of random lines, one thread, s", ["scene", "visible", "lazy", "full", "lazy / full"], table)
    table = []
    for title, scene in OBJECTS:
        rows = timed(bench, options, scene, "closeup", 10_000, "lazy,full,embree-low,embree-lazy")
        lazy, peer = rows["lazy"], rows.get("embree-lazy", {})
        ms = [1e3 * rows[m]["seconds_to_hits"] if m in rows else None for m in ("lazy", "full", "embree-low", "embree-lazy")]
        table.append([title, *ms, lazy.get("over_embree_lazy"), lazy["triangles_touched"], peer.get("triangles_touched"),
                      peer.get("objects_built")])
    print_table("Scenes of objects: from arrays to 10,000 hits of a close-up, one thread, ms",
                ["scene", "lazy", "full", "Embree LOW", "Embree lazy", "lazy / Embree lazy", "triangles in our trees",
                 "in Embree's", "objects it built"], table)


def kernels(bench, options):
    rows = bench.rows("kernel", "--repeat", options.repeat)
    table = []
    for name in dict.fromkeys(r["pass"] for r in rows):
        near, far = [r for r in rows if r["pass"] == name]
        table.append([name, f"{near['planes']} x {near['axes']}", near["mboxes_per_s"], far["mboxes_per_s"], percent(near["of_490_mboxes_16x3"])])
    print_table(f"Million boxes a second, one thread, {rows[0]['target']}",
                ["pass", "planes x axes", f"{rows[0]['kib']} KiB", f"{rows[-1]['kib'] // 1024} MiB", "comparisons of 490 M x 16 x 3"], table)


def print_all(bench, options):
    """Everything, in the order of the page."""
    print(f"Load average {os.getloadavg()[0]:.1f} when this began; medians of {options.repeat}.")
    for table in (law, unordered, nodes, times, kernels):
        table(bench, options)
