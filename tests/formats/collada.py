"""A second reader of Collada, for comparison: triangles in the world, in metres and in the file's axes, without animation."""

import math
import re
import xml.etree.ElementTree

from measures import Damaged, Measures, Unknown, picked

IDENTITY = [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]


def product(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def numbers(text):
    """Some programs write decimal commas."""
    return [float(word.replace(",", ".", 1)) for word in (text or "").split()]


def integers(element):
    return [int(word) for word in (element.text or "").split()] if element is not None else []


def turn(x, y, z, degrees):
    size = math.sqrt(x * x + y * y + z * z) or 1
    x, y, z, a = x / size, y / size, z / size, math.radians(degrees)
    c, s = math.cos(a), math.sin(a)
    t = 1 - c
    return [[t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0], [t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0], [0, 0, 0, 1]]


def transform(element):
    n, tag = numbers(element.text), element.tag
    if len(n) != {"matrix": 16, "translate": 3, "scale": 3, "rotate": 4}.get(tag, len(n)):
        raise Damaged(f"{tag} of {len(n)} numbers")
    if tag == "matrix":
        return [n[4 * r:4 * r + 4] for r in range(4)]
    if tag == "translate":
        return [[1, 0, 0, n[0]], [0, 1, 0, n[1]], [0, 0, 1, n[2]], [0, 0, 0, 1]]
    if tag == "scale":
        return [[n[0], 0, 0, 0], [0, n[1], 0, 0], [0, 0, n[2], 0], [0, 0, 0, 1]]
    if tag == "rotate":
        return turn(*n)
    return None


class Reader:
    def __init__(self, text):
        text = re.sub(r'\sxmlns="[^"]*"', "", text, count=1)
        text = re.sub(r"^\ufeff?\s*<\?xml.*?\?>", "", text, flags=re.DOTALL)  # it is in UTF-8 here
        self.root = xml.etree.ElementTree.fromstring(text)
        self.by_id = {e.get("id"): e for e in self.root.iter() if e.get("id")}
        self.geometries = {}
        self.has_skins = False
        self.polygons = []  # lists of points in the world
        unit = self.root.find("asset/unit")
        self.meters = float(unit.get("meter", "1").replace(",", ".")) if unit is not None else 1.0
        self.up = (self.root.findtext("asset/up_axis") or "Y_UP").strip()
        scene = self.root.find("scene/instance_visual_scene")
        if scene is None:
            raise Unknown("no scene")
        m = self.meters
        start = product([[m, 0, 0, 0], [0, m, 0, 0], [0, 0, m, 0], [0, 0, 0, 1]], IDENTITY)
        for node in self.named(scene.get("url")).findall("node"):
            self.visit(node, start, 0)

    def named(self, url):
        if not (url or "").startswith("#") or url[1:] not in self.by_id:
            raise Unknown(f"{url}")
        return self.by_id[url[1:]]

    def visit(self, node, matrix, depth):
        if depth > 100:
            raise Unknown("deep")
        for child in node:
            step = transform(child)
            if step is not None:
                matrix = product(matrix, step)
            elif child.tag in ("lookat", "skew"):
                raise Unknown(child.tag)
        for child in node:
            if child.tag == "node":
                self.visit(child, matrix, depth + 1)
            elif child.tag == "instance_node":
                self.visit(self.named(child.get("url")), matrix, depth + 1)
            elif child.tag == "instance_geometry":
                self.place(self.named(child.get("url")), matrix)
            elif child.tag == "instance_controller":
                self.has_skins = True
                source = self.named(child.get("url"))
                while source.tag == "controller":
                    part = source.find("skin") if source.find("skin") is not None else source.find("morph")
                    source = self.named(part.get("source"))
                self.place(source, matrix)

    def place(self, geometry, matrix):
        key = geometry.get("id")
        if key not in self.geometries:
            self.geometries[key] = list(self.faces(geometry.find("mesh")))
        for points in self.geometries[key]:
            self.polygons.append([tuple(sum(matrix[r][k] * p[k] for k in range(3)) + matrix[r][3] for r in range(3))
                                  for p in points])

    def positions(self, mesh, vertices_url):
        vertices = self.named(vertices_url)
        source = next((self.named(i.get("source")) for i in vertices.findall("input") if i.get("semantic") == "POSITION"), None)
        if source is None:
            raise Unknown("no positions")
        accessor = source.find("technique_common/accessor")
        values = numbers(self.named(accessor.get("source")).text)
        stride, offset = int(accessor.get("stride", 1)), int(accessor.get("offset", 0))
        names = [p.get("name") for p in accessor.findall("param")]
        axes = [names.index(n) for n in "XYZ"] if all(n in names for n in "XYZ") else [0, 1, 2]
        return [tuple(picked(values, offset + i * stride + k) for k in axes) for i in range(int(accessor.get("count")))]

    def faces(self, mesh):
        if mesh is None:
            return
        for primitive in mesh:
            if primitive.tag not in ("triangles", "polylist", "polygons", "tristrips", "trifans"):
                continue
            inputs = primitive.findall("input")
            stride = max((int(i.get("offset", 0)) for i in inputs), default=0) + 1
            vertex = next(i for i in inputs if i.get("semantic") == "VERTEX")
            points, at = self.positions(mesh, vertex.get("source")), int(vertex.get("offset", 0))
            lists = [[picked(points, k) for k in integers(p)[at::stride]] for p in primitive.findall("p")]
            if primitive.find("ph") is not None:
                raise Unknown("holes")
            if primitive.tag == "polygons":
                yield from (corners for corners in lists if len(corners) > 2)
            elif primitive.tag == "triangles":
                for corners in lists:
                    yield from (corners[i:i + 3] for i in range(0, len(corners) - 2, 3))
            elif primitive.tag == "polylist":
                counts = integers(primitive.find("vcount"))
                if sum(counts) > sum(map(len, lists)):
                    raise Damaged("polygons have more corners than there are")
                first = 0
                for count in counts:
                    if count > 2:
                        yield lists[0][first:first + count]
                    first += count
            else:
                for corners in lists:
                    for i in range(len(corners) - 2):
                        if primitive.tag == "trifans":
                            yield [corners[0], corners[i + 1], corners[i + 2]]
                        else:
                            yield [corners[i + i % 2], corners[i + 1 - i % 2], corners[i + 2]]


def measures(data, _=None):
    read = Reader(data.decode(errors="replace"))
    if read.up == "X_UP":
        raise Unknown("the x axis is up")
    return Measures(read.polygons, not read.has_skins)
