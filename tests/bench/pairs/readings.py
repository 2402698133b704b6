"""Reads the rows of a run: costs of ours and of its peers, and the answers, which must be equal in every run.

A reading is a pair of dictionaries. The first has the cost of each side by quantity and unit: {("trace", "ns/ray"): {"ours": 120.0,
"embree-high": 100.0}}. The second has the answers.
"""
from programs import Failed

OURS = "ours"


def check_explained(row, key="unexplained", name=""):
    if row.get(key):
        raise Failed(f"{name or row.get('builder') or row['mode']}: {row[key]} answers that nothing explains")


def by_side(rows, key):
    """The rows by their side: Embree's by their name. All others must be one, ours."""
    sides = {row[key] if row[key].startswith("embree") else OURS: row for row in rows}
    if OURS not in sides or len(sides) != len(rows):
        raise Failed(f"its rows are of {', '.join(row[key] for row in rows)}")
    return sides


def trace(rows):
    sides = by_side(rows, "builder")
    for row in rows:
        check_explained(row)
    ours = sides[OURS]
    return ({("trace", "ns/ray"): {side: 1e6 * row["trace_ms"] / row["count"] for side, row in sides.items()}},
            {key: ours[key] for key in ("hit_hash", "hits", "count")})


def build(rows):
    sides = by_side(rows, "builder")
    cost = lambda key: {side: row[key] / row["triangles"] for side, row in sides.items()}
    return ({("build", "ms"): {side: row["build_ms"] for side, row in sides.items()},
             ("bytes, final", "B/triangle"): cost("bytes_final"), ("bytes, peak", "B/triangle"): cost("bytes_peak")},
            {"triangles": sides[OURS]["triangles"]})


def lazy(rows):
    sides = by_side(rows, "mode")
    for row in rows:
        check_explained(row)
    ours = sides[OURS]
    return ({("arrays to hits", "ms"): {side: 1e3 * row["seconds_to_hits"] for side, row in sides.items()}},
            {key: ours[key] for key in ("hit_hash", "hits", "count")})


def answers(rows):
    """The verb fails if one of its ways differs from the first."""
    return {}, {key: rows[0][key] for key in ("rays", "closest", "any", "count", "all")}


def robust(rows):
    exact = [row for row in rows if row["method"] == "exact"]
    if not exact:
        raise Failed("no row of the method exact")
    for row in exact:
        if wrong := {key: row[key] for key in ("missed", "extra", "mismatched") if row[key]}:
            raise Failed(f"{row['family']}, {row['kind']}, {row['builder']}, {row['policy']}: {wrong}")
    return {}, {"rays": sum(row["rays"] for row in exact), "missed, extra or mismatched": 0}


def remote(rows):
    """The verb compares the answers with those in process."""
    costs = {}
    for row in rows:
        if "one_ray" in row:
            costs[f"one ray, {row['one_ray']}", "us"] = {OURS: row["p50_us"], "echo": row["echo_p50_us"]}
            continue
        costs[f"{row['columns']}: processor over in process", "ns/ray"] = {OURS: row["over_ns_per_ray"]}
        costs[f"{row['columns']}: wall", "ns/ray"] = {OURS: 1e3 / row["mrays_per_s"], "in process": 1e3 / row["in_process_mrays_per_s"]}
    return costs, {row["columns"]: row["count"] for row in rows if "columns" in row}


def motion(rows):
    """The last row has the medians over the frames."""
    last = rows[-1]
    peers = {key[:-len("_fps")].replace("_", "-"): last[key] for key in last if key.startswith("embree") and key.endswith("_fps")}
    for peer in peers:
        check_explained(last, f"{peer.replace('-', '_')}_unexplained", peer)
    return ({("frame", "ms"): {side: 1e3 / fps for side, fps in {OURS: last["fps"], **peers}.items()}},
            {"frames": [row["hit_hash"] for row in rows if "hit_hash" in row]})
