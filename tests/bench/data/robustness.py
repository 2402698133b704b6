"""Parts about robustness: lost rays, hard meshes, and the price of exact hits."""
from bench import Failed

ROBUST = "scan-fast", "scan-best", "bvh-binned", "sbvh"
STABILITY = ("family", "builder", "triangles", "ok", "wrong", "references_per_triangle", "max_depth", "touches_per_triangle",
             "bytes_peak_per_triangle", "steps_per_ray", "tests_per_ray", "relative_work", "failures", "failed_by_design")
CLUSTERS = ("kind", "builder", "triangles", "wrong", "final", "peak_full", "peak_growing", "resident_peak_full",
            "resident_peak_growing", "references_per_triangle", "touches_per_triangle", "steps_per_ray", "tests_per_ray",
            "relative_work")


def robust(bench, options):
    rows = bench.rows("robust", "--scene", "{bunny}", "--level", 5, "--count", 40_000, "--builder", ",".join(ROBUST),
                      "--threads", 1)
    wrong = [row for row in rows if row["method"] == "exact" and (row["missed"] or row["extra"] or row["mismatched"])]
    if wrong:
        raise Failed(f"exact hits are wrong: {wrong[0]}")
    return {"robust": [{key: row[key] for key in ("family", "kind", "builder", "policy", "method", "rays", "missed", "extra",
                                                  "checked", "mismatched", "mrays_per_s")} for row in rows]}


def stability(bench, options):
    rows = bench.rows("stability", "--triangles", 3000, "--threads", 1, "--repeat", 1)
    return {"stability": [{key: row.get(key) for key in STABILITY} for row in rows]}


def clusters(bench, options):
    rows = []
    for triangles in 1000, 30_000, 1_000_000:
        rows += bench.rows("clusters", "--triangles", triangles, "--threads", 1)
    wrong = [row for row in rows if row["wrong"]]
    if wrong:
        raise Failed(f"growing and full trees disagree: {wrong[0]}")
    return {"clusters": [{key: row.get(key) for key in CLUSTERS} for row in rows]}


def exactness(bench, options):
    rows = []
    for scene in "bunny", "sponza", "conference":
        for row in bench.rows("exactness", "--scene", f"{{{scene}}}", "--count", 100_000, "--repeat", 2 * options.repeat + 1,
                              "--threads", 1):
            if row["unexplained"]:
                raise Failed(f"{scene}: {row['unexplained']} answers that nothing explains")
            rows.append({"scene": scene, "rays": row["rays"], "count": row["count"], "exact_over_float": row["ratio"],
                         "product_over_float": row["ratio_product"], "differences": row["differences"]})
    return {"exactness": rows}
