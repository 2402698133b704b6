"""Hits and distances by looking at every triangle in float64, and meshes and rays to look at."""

import numpy as np


def hits(vertices, faces, origins, directions, tmin=0.0, tmax=np.inf):
    """t (n, f) of each ray with each face, NaN where it is not hit."""
    corners = np.asarray(vertices, "f4").astype("f8")[np.asarray(faces)]
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    origins, directions = np.asarray(origins, "f8"), np.asarray(directions, "f8")
    p = np.cross(directions[:, None], edge2[None])
    det = np.einsum("fk,nfk->nf", edge1, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origins[:, None] - corners[None, :, 0]
        u = np.einsum("nfk,nfk->nf", s, p) / det
        q = np.cross(s, edge1[None])
        v = np.einsum("nk,nfk->nf", directions, q) / det
        t = np.einsum("fk,nfk->nf", edge2, q) / det
        is_hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= tmin) & (t <= tmax)
    return np.where(is_hit, t, np.nan)


def closest(vertices, faces, origins, directions, **bounds):
    """t (n), +inf for a miss, and the face (n)."""
    t = hits(vertices, faces, origins, directions, **bounds)
    t = np.where(np.isnan(t), np.inf, t)
    return t.min(axis=1), t.argmin(axis=1)


def distances(vertices, faces, points):
    """Distances (n, f) of points from faces, and where on them (n, f, 3) the nearest points are."""
    corners = np.asarray(vertices, "f4").astype("f8")[np.asarray(faces)]
    points = np.asarray(points, "f8")[:, None]
    distance, nearest = np.full(points.shape[:1] + corners.shape[:1], np.inf), np.zeros((len(points), len(corners), 3))

    def offer(where, is_there=True):
        length = np.where(is_there, np.linalg.norm(where - points, axis=-1), np.inf)
        nearest[length < distance] = np.broadcast_to(where, nearest.shape)[length < distance]
        np.minimum(distance, length, out=distance)

    for k in range(3):
        start, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        square = np.maximum((along ** 2).sum(axis=-1), 1e-300)
        offer(start + np.clip(((points - start) * along).sum(axis=-1) / square, 0, 1)[..., None] * along)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    square = (normal ** 2).sum(axis=-1)
    height = ((points - corners[:, 0]) * normal).sum(axis=-1) / np.maximum(square, 1e-300)
    foot = points - height[..., None] * normal
    sides = [(np.cross(corners[:, (k + 1) % 3] - corners[:, k], foot - corners[:, k]) * normal).sum(axis=-1) >= 0
             for k in range(3)]
    offer(foot, np.all(sides, axis=0) & (square > 0))
    return distance, nearest


def box():
    """A closed mesh, vertices (8, 3) and faces (12, 3), of side 1 from the origin."""
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return vertices, faces


def soup(count=200, seed=1):
    """Triangles anywhere in the unit cube."""
    rng = np.random.default_rng(seed)
    middles = rng.random((count, 1, 3))
    vertices = (middles + rng.normal(scale=0.1, size=(count, 3, 3))).reshape(-1, 3).astype("f4")
    return vertices, np.arange(3 * count).reshape(count, 3)


def rays(count, seed=2):
    """(n, 6) float64 through the unit cube."""
    rng = np.random.default_rng(seed)
    origins = rng.uniform(-1, 2, (count, 3))
    return np.hstack([origins, rng.random((count, 3)) - origins])
