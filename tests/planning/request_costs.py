"""Unit costs of requests, measured: warm and cold, at clients, HAProxy and replicas."""
import dataclasses

import numpy as np
import sightline

from closed_loop import closed_loop
from terrain import terrain, window_rays
from workload import popularity, reach, scene_triangles

GROWTH_SCENES, COLD_SCENES = 8, 24
VISITS, COLD_VISITS = 16, 3  # requests at each scene
PIECES = 2.0 ** np.arange(0, 12, 0.25)  # tried for piece_triangles


@dataclasses.dataclass(frozen=True)
class Growth:
    """Requests one after the other at cold scenes: rows are scenes, columns visits."""
    triangles: np.ndarray
    built: np.ndarray     # triangles in finished leaves, after the visit
    geometry_bytes: float
    tree_bytes: float


@dataclasses.dataclass(frozen=True)
class ColdRun:
    """Requests at a replica that had not loaded the scenes, or had; what they took beyond warm ones."""
    extra_s: float        # of the replica
    client_s: float
    store_s: float        # of PostgreSQL
    opened: int           # scenes
    opened_triangles: float
    built: float          # triangles


def put_scenes(endpoint, prefix, sizes, seed):
    """Imports terrains of these sizes; returns their names and the triangles that they have."""
    client = sightline.connect(endpoint, token="")
    names, triangles = [], []
    for number, size in enumerate(sizes):
        vertices, faces = terrain(size, seed + number)
        client.import_arrays(f"{prefix}{number}", vertices, faces, replace=True)  # of an earlier run
        names.append(f"{prefix}{number}")
        triangles.append(len(faces))
    client.close()
    return names, np.array(triangles, float)


def built_by(port, names):
    """Triangles in finished leaves, of each scene, at one replica."""
    client = sightline.connect(f"127.0.0.1:{port}", token="")
    counts = [client.scene(name).stats().triangles_built for name in names]
    client.close()
    return np.array(counts, float)


def watch_growth(port, names, triangles, work):
    """At one replica, by one client."""
    client, random = sightline.connect(f"127.0.0.1:{port}", token=""), np.random.default_rng(work.seed)
    built, geometry, trees = [], [], []
    for name in names:
        scene, row = client.scene(name), []
        for _ in range(VISITS):
            scene.cast(window_rays(random, work.rays, work.window), fields=("t", "node", "primitive"))
            row.append(scene.stats())
        built.append([stats.triangles_built for stats in row])
        geometry.append(row[-1].bytes_geometry / row[-1].triangles_total)
        trees.append(row[-1].bytes_trees / row[-1].triangles_built)
    client.close()
    return Growth(triangles, np.array(built, float), float(np.mean(geometry)), float(np.mean(trees)))


def fit_pieces(growth, work):
    """The piece_triangles whose growth is nearest to what was seen, by the mean error of its logarithm."""
    count = np.arange(1, VISITS + 1)

    def error(piece):
        share = reach(work, growth.triangles, piece)
        model = growth.triangles[:, None] * (1 - (1 - share[:, None]) ** count)
        return float(np.abs(np.log(model / growth.built)).mean())

    return float(min(PIECES, key=error))


def cold_runs(cluster, port, names, triangles, work, clients, warm):
    """Small scenes, then large ones, then all of them again: each scene is opened once, and grows twice. warm: a run for comparison."""
    order = np.argsort(triangles)
    half = len(order) // 2
    runs, endpoint = [], f"127.0.0.1:{port}"
    for number, (chosen, opens) in enumerate(((order[:half], True), (order[half:], True), (order, False))):
        some = [names[i] for i in chosen]
        before = 0 if opens else built_by(port, some).sum()
        run = closed_loop(cluster, endpoint, some, np.full(len(some), 1 / len(some)), clients,
                          max(1, COLD_VISITS * len(some) // clients), work.rays, work.window, 20 + number)
        built = built_by(port, some)
        runs.append(ColdRun((run.server_s - warm.server_s) * run.requests, (run.client_s - warm.client_s) * run.requests,
                            run.store_s * run.requests, opens * int((built > 0).sum()),
                            opens * float(triangles[chosen][built > 0].sum()), float(built.sum() - before)))
    return runs


def fit_cold(runs):
    """open_scene_s, open_triangle_s, build_triangle_s: the cost of runs, by their counts; none is negative."""
    counts = np.array([[run.opened, run.opened_triangles, run.built] for run in runs])
    extra = np.array([run.extra_s for run in runs])
    best = None
    for used in ((0, 1, 2), (1, 2), (0, 2), (2,)):
        found = np.zeros(3)
        found[list(used)] = np.linalg.lstsq(counts[:, used], extra, rcond=None)[0]
        if (found >= 0).all():
            best = found
            break
    if best is None:
        raise RuntimeError(f"cold requests took no longer than warm ones: {runs}")
    return tuple(map(float, best))


def two_sizes(of_few, of_many, few, many):
    """The cost of a request and of a ray, of what requests of few and of many rays cost."""
    ray = max(0.0, (of_many - of_few) / (many - few))
    return max(0.0, of_many - ray * many), ray


def grow_all(cluster, names, work):
    """Builds the trees of these scenes at every replica."""
    random = np.random.default_rng(work.seed)
    for port in cluster.replicas:
        client = sightline.connect(f"127.0.0.1:{port}", token="")
        for name in names:
            for _ in range(4):
                client.scene(name).cast(window_rays(random, 32_768, 1.0), fields=("t",))
        client.close()


def scene_sizes(work):
    """Of the scenes that `request_costs` needs: those of the workload, to be warm, and some to be cold."""
    return scene_triangles(dataclasses.replace(work, scenes=work.scenes + GROWTH_SCENES + COLD_SCENES, seed=5))


def warm_run(cluster, endpoint, names, work, clients, requests, rays, proxy):
    """All scenes of the workload, as often as there: how much of the replicas' memory is touched decides what a ray costs."""
    return closed_loop(cluster, endpoint, names, popularity(work), clients, requests, rays, work.window, 7, proxy=proxy)


def request_costs(cluster, scenes, work, clients, requests, bound=None):
    """The fields of Costs that concern requests. scenes: what `put_scenes` returned for `scene_sizes`; no one has used them.
    Without a bound, what bounded loads cost is 0."""
    few, many = work.rays // 4, work.rays
    part = lambda begin, count: (scenes[0][begin:begin + count], scenes[1][begin:begin + count])
    warm = part(0, work.scenes)[0]
    grow_all(cluster, warm, work)
    run = lambda endpoint, rays, proxy: warm_run(cluster, endpoint, warm, work, clients, requests, rays, proxy)
    direct = [run(cluster.endpoints(), rays, False) for rays in (few, many)]
    proxy = cluster.start_haproxy()
    through = [run(proxy, rays, True) for rays in (few, many)]
    bounded = run(cluster.start_haproxy(bound), many, True) if bound else through[1]
    port = next(iter(cluster.replicas))
    growth = watch_growth(port, *part(work.scenes, GROWTH_SCENES), work)
    cold = cold_runs(cluster, port, *part(work.scenes + GROWTH_SCENES, COLD_SCENES), work, clients, direct[1])
    found = dict(zip(("open_scene_s", "open_triangle_s", "build_triangle_s"), fit_cold(cold)))
    found["database_open_triangle_s"] = sum(run.store_s for run in cold) / sum(run.opened_triangles for run in cold)
    found["piece_triangles"] = fit_pieces(growth, work)
    for who in "client", "server":
        costs = two_sizes(getattr(direct[0], f"{who}_s"), getattr(direct[1], f"{who}_s"), few, many)
        found[f"{who}_request_s"], found[f"{who}_ray_s"] = costs
        found[f"{who}_proxied_s"] = max(0.0, getattr(through[1], f"{who}_s") - getattr(direct[1], f"{who}_s"))
    found["proxy_request_s"], found["proxy_ray_s"] = two_sizes(through[0].proxy_s, through[1].proxy_s, few, many)
    found["proxy_bounded_s"] = max(0.0, bounded.proxy_s - through[1].proxy_s)
    found["client_triangle_s"] = max(0.0, sum(run.client_s for run in cold) / sum(run.built for run in cold))
    found["geometry_bytes"], found["tree_bytes"] = growth.geometry_bytes, growth.tree_bytes
    return found
