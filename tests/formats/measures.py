"""What two readers of a file agree on: the number of triangles, their bounds, their area, and the side that they turn outward."""

import math
import re

NEAR = 1e-4       # of the size, for bounds
NEAR_AREA = 1e-3  # of the area
MOST = 1e30       # larger coordinates may be too large for float32
NUMBER = re.compile(rb"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|[+-]?(inf|infinity|nan)", re.IGNORECASE)


class Unknown(Exception):
    """The file has what a second reader does not understand."""


class Damaged(Exception):
    """The file breaks its format."""


def number(word):
    if not NUMBER.fullmatch(word):
        raise Damaged(f"{word[:40]!r} is no number")
    return float(word)


def integer(word):
    if not re.fullmatch(rb"[+-]?\d+", word):
        raise Damaged(f"{word[:40]!r} is no integer")
    return int(word)


def picked(items, index):
    if not 0 <= index < len(items):
        raise Damaged(f"{index} of {len(items)} is named")
    return items[index]


def vector_area(polygon):
    """Any way to cut the polygon into triangles keeps it."""
    x, y, z = polygon[0]
    sums = [0.0, 0.0, 0.0]
    for p, q in zip(polygon[1:], polygon[2:]):
        a, b = (p[0] - x, p[1] - y, p[2] - z), (q[0] - x, q[1] - y, q[2] - z)
        for k in range(3):
            sums[k] += (a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]) / 2
    return sums


def is_flat(polygon):
    """Whether all ways to cut it have one area."""
    if len(polygon) == 3:
        return True
    normal = vector_area(polygon)
    length = math.hypot(*normal)
    size = max(math.dist(polygon[0], p) for p in polygon)
    return all(abs(sum(n * (a - b) for n, a, b in zip(normal, p, polygon[0]))) <= NEAR * length * size for p in polygon)


class Measures:
    """Of polygons, which are lists of points. Those of fewer than three corners have no triangle."""

    def __init__(self, polygons, is_placed=True):
        """is_placed: whether the points are where they should be."""
        polygons = [polygon for polygon in polygons if len(polygon) > 2]
        self.triangles = sum(len(polygon) - 2 for polygon in polygons)
        self.has_shape = is_placed and bool(polygons) and all(abs(x) < MOST for polygon in polygons for p in polygon for x in p)
        if not self.has_shape:
            return
        self.bounds = [f(p[k] for polygon in polygons for p in polygon) for f in (min, max) for k in range(3)]
        self.size = math.dist(self.bounds[:3], self.bounds[3:])
        areas = [vector_area(polygon) for polygon in polygons]
        self.area = sum(math.hypot(*area) for area in areas)
        self.turned = [sum(area[k] for area in areas) for k in range(3)]
        self.is_flat = all(map(is_flat, polygons))

    def difference(self, wanted, is_counted=True):
        """What of these measures is not as `wanted`; empty: nothing. is_counted: whether the number of triangles is one of them."""
        if is_counted and self.triangles != wanted.triangles:
            return f"{self.triangles} triangles, not {wanted.triangles}"
        if not (self.has_shape and wanted.has_shape):
            return ""
        if any(abs(a - b) > NEAR * wanted.size for a, b in zip(self.bounds, wanted.bounds)):
            return f"bounds {self.bounds}, not {wanted.bounds}"
        bound = NEAR_AREA * wanted.area + NEAR * wanted.size * wanted.size
        if wanted.area - self.area > bound or (wanted.is_flat and self.area - wanted.area > bound):
            return f"area {self.area}, not {wanted.area}"
        if math.dist(self.turned, wanted.turned) > bound:
            return f"area to the axes {self.turned}, not {wanted.turned}"
        return ""


def triangles_of_export(text):
    """Of an OBJ file that `sightline scene export` wrote, as bytes."""
    vertices, triangles = [], []
    for line in text.splitlines():
        words = line.split()
        if words[:1] == [b"v"]:
            vertices.append(tuple(map(float, words[1:4])))
        elif words[:1] == [b"f"]:
            triangles.append([vertices[int(word) - 1] for word in words[1:4]])
    return triangles
