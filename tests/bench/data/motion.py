"""The part about scenes that move: frames over a static scene, and two trees instead of one."""
from bench import Failed

SWARM = ("dynamic", "--frames", "gen:swarm?triangles=50000", "--static", "gen:terrain?triangles=1000000", "--static-small",
         "gen:terrain?triangles=50000", "--rays", "overview", "--count", 65_536, "--length", 32)
HORSES = ("dynamic", "--frames", "{horse_gallop}", "--copies", 12, "--rays", "overview", "--count", 262_144, "--shadow",
          "--length", 12, "--peers", "embree-low,embree-refit")
CITY = "gen:city?triangles=400000"


def frames(bench, title, command):
    """The last row of a show: medians over its frames; a line a quantity."""
    last = bench.rows(*command, "--threads", 1)[-1]
    unexplained = [key for key in last if key.endswith("_unexplained") and last[key]]
    if unexplained:
        raise Failed(f"{title}: {unexplained[0]}: {last[unexplained[0]]}")
    wanted = [key for key in last if key.endswith(("_ms", "fps", "_touches", "_over_static", "_over_small", "_q1", "_q3"))]
    return [{"show": title, "quantity": key, "figure": float(last[key])} for key in wanted]


def motion(bench, options):
    table = frames(bench, "50,000 triangles over a terrain of 1 M", SWARM)
    table += frames(bench, "12 horses, 202,116 triangles, with shadow rays", HORSES)
    for kind in "overview", "random":
        for row in bench.rows("two-trees", "--scene", CITY, "--rays", kind, "--count", 100_000, "--threads", 1, "--repeat",
                              2 * options.repeat + 1):
            if "ratio" in row:
                table.append({"show": f"city of 400,000 triangles, {kind} rays", "quantity": f"{row['variant']}, over {row['over']}",
                              "figure": float(row["ratio"])})
    return {"motion": table}
