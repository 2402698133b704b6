"""Parts about lazy growth: the law of touches, worlds of growing size, time to hits, and the inner loops."""
from bench import Failed

LAW = ("what", "hierarchy", "n", "m", "share", "windows", "rays", "points", "touches", "touches_prepare", "fitted",
       "over_n_log_cells", "a", "b", "r_squared", "max_residual")
UNORDERED = {"bunny as scanned": "{bunny}", "bunny, faces shuffled": "gen:shuffled?mesh={bunny}"}
VILLAGES = "triangles", "nodes", "touches", "touches_first", "touches_prepare", "first_hit_us", "first_hit_cold_us"


def law(bench, options):
    rows = bench.rows("law", "--threads", 1, "--max-n", 19, "--windows", 8)
    table = [{"scene": "gen:terrain", **{key: row[key] for key in LAW if key in row}} for row in rows]
    for name, scene in UNORDERED.items():
        rows = bench.rows("law", "--scene", scene, "--threads", 1, "--windows", 4)
        table += [{"scene": name, "what": "worst", "hierarchy": row["hierarchy"], "over_soup": row["over_soup"]}
                  for row in rows if row["what"] == "worst"]
    return {"lazy_law": table}


def villages(bench, options):
    rows = bench.rows("law", "--nodes", "--threads", 1, "--max-n", 22, "--repeat", options.repeat)
    return {"villages": [{key: row[key] for key in VILLAGES} for row in rows if row["what"] == "point"]}


TIMES = {"dragon": "{dragon}", "sponza": "{sponza}", "torcs_forza": "{torcs_forza}", "city, 400 objects": "gen:city?boxes=20000",
         "city, 1,667 objects": "gen:city?triangles=1000000", "terrain": "gen:terrain?triangles=1000000",
         "herd of 30 bunnies": "gen:herd?copies=30&mesh={bunny}"}
EVERYWHERE = "dragon", "sponza", "torcs_forza", "terrain"
MODES = "lazy,full,embree-low,embree-lazy"
COLUMNS = "seconds_to_hits", "build_ms", "trace_ms", "triangles_total", "triangles_touched", "visible_fraction", "touches"


def timed(bench, options, name, rays, count, modes):
    rows = bench.rows("lazy", "--scene", TIMES[name], "--rays", rays, "--count", count, "--modes", modes, "--threads", 1,
                      "--repeat", options.repeat)
    for row in rows:
        if row.get("unexplained"):
            raise Failed(f"{name}: {row['mode']} has {row['unexplained']} answers that nothing explains")
    quotients = next(row for row in rows if row["mode"] == "lazy")
    return [{"scene": name, "rays": rays, "count": count, "mode": row["mode"], **{key: row.get(key) for key in COLUMNS},
             "lazy_over_this": quotients.get("over_" + row["mode"].replace("-", "_"))} for row in rows]


def times(bench, options):
    table = [row for name in TIMES for row in timed(bench, options, name, "closeup", 10_000, MODES)]
    table += [row for name in EVERYWHERE for row in timed(bench, options, name, "random", 300_000, "lazy,full")]
    return {"lazy_times": table}


def kernel(bench, options):
    keys = "pass", "target", "boxes", "kib", "planes", "axes", "mboxes_per_s", "of_490_mboxes_16x3"
    return {"kernel": [{key: row[key] for key in keys} for row in bench.rows("kernel", "--repeat", options.repeat)]}
