"""The part about growth by demand: what each policy costs, from one ray to many."""

SCENES = {"dragon": "{dragon}", "sibenik": "{sibenik}", "terrain": "gen:terrain?triangles=1000000",
          "slivers": "gen:slivers?triangles=100000", "city": "gen:city?triangles=1000000"}
COLUMNS = "policy", "kind", "rays", "seconds", "basis", "over_best", "competitive_ratio", "ratio_to_embree"


def competitive(bench, options):
    """A row a scene, policy, kind of rays and number of rays; the last of a scene has its worst ratio."""
    table = []
    for name, scene in SCENES.items():
        rows = bench.rows("competitive", "--scene", scene, "--threads", 1, "--repeat", options.repeat)
        table += [{"scene": name, **{key: row.get(key) for key in COLUMNS}} for row in rows]
    return {"competitive": table}
