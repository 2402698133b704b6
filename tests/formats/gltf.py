"""A second reader of glTF 2.0, for comparison: triangles in the scene, with default weights and skins, without animation."""

import base64
import json
import math
import struct
import urllib.parse

from collada import IDENTITY, product
from measures import Damaged, Unknown, picked

CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
GEOMETRY = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "KHR_node_visibility"}


def chunks(data):
    """The JSON and the bytes of a binary file."""
    magic, version, length = struct.unpack_from("<4sII", data)
    if magic != b"glTF" or version != 2 or length > len(data):
        raise Damaged("the header of the container")
    at, found = 12, []
    while at + 8 <= length:
        size, kind = struct.unpack_from("<I4s", data, at)
        if at + 8 + size > length:
            raise Damaged("a chunk is cut off")
        found.append((kind, data[at + 8:at + 8 + size]))
        at += 8 + size
    if not found or found[0][0] != b"JSON":
        raise Damaged("no JSON")
    return found[0][1], found[1][1] if found[1:] and found[1][0] == b"BIN\0" else None


def rows(matrix):
    """Of a matrix that is stored by columns."""
    return [[matrix[4 * c + r] for c in range(4)] for r in range(4)]


def local(node):
    if "matrix" in node:
        if len(node["matrix"]) != 16:
            raise Damaged("a matrix")
        return rows(node["matrix"])
    (x, y, z), (sx, sy, sz) = node.get("translation", (0, 0, 0)), node.get("scale", (1, 1, 1))
    a, b, c, w = node.get("rotation", (0, 0, 0, 1))
    size = math.sqrt(a * a + b * b + c * c + w * w) or 1
    a, b, c, w = a / size, b / size, c / size, w / size if a or b or c or w else 1
    return [[(1 - 2 * (b * b + c * c)) * sx, 2 * (a * b - c * w) * sy, 2 * (a * c + b * w) * sz, x],
            [2 * (a * b + c * w) * sx, (1 - 2 * (a * a + c * c)) * sy, 2 * (b * c - a * w) * sz, y],
            [2 * (a * c - b * w) * sx, 2 * (b * c + a * w) * sy, (1 - 2 * (a * a + b * b)) * sz, z], [0, 0, 0, 1]]


def placed(m, p):
    return tuple(m[r][0] * p[0] + m[r][1] * p[1] + m[r][2] * p[2] + m[r][3] for r in range(3))


class Reader:
    def __init__(self, data, files):
        self.files, self.buffers = files, {}
        text, self.binary = chunks(data) if data[:4] == b"glTF" else (data, None)
        self.json = json.loads(text)
        if GEOMETRY & set(self.json.get("extensionsUsed", [])) or any(name.encode() in text for name in GEOMETRY):
            raise Unknown("extensions")
        scenes = self.json.get("scenes", [])
        if len(scenes) != 1 or self.json.get("scene", 0) != 0:
            raise Unknown("scenes")
        self.world, self.polygons, with_mesh = {}, [], []
        open_nodes = [(index, IDENTITY) for index in scenes[0].get("nodes", [])]
        while open_nodes:
            index, above = open_nodes.pop()
            if index in self.world:
                raise Damaged(f"node {index} is met twice")
            node = picked(self.json["nodes"], index)
            self.world[index] = product(above, local(node))
            open_nodes += [(child, self.world[index]) for child in node.get("children", [])]
            if "mesh" in node:
                with_mesh.append(index)
        for index in with_mesh:
            self.place(index)

    def buffer(self, index):
        if index not in self.buffers:
            buffer = picked(self.json["buffers"], index)
            uri = buffer.get("uri")
            if uri is None:
                data = self.binary
            elif uri.startswith("data:"):
                data = base64.b64decode(uri.split(",", 1)[1], validate=True)
            else:
                data = self.files(urllib.parse.unquote(uri))
            if data is None or len(data) < buffer["byteLength"]:
                raise Damaged(f"buffer {index}")
            self.buffers[index] = data[:buffer["byteLength"]]
        return self.buffers[index]

    def items(self, part, count, code, width):
        """`count` lists of numbers of a part: an accessor, or one of its sparse ones."""
        view = picked(self.json["bufferViews"], part["bufferView"])
        form = f"<{width}{code}"
        size, begin, length = struct.calcsize(form), view.get("byteOffset", 0), view["byteLength"]
        stride, at, buffer = view.get("byteStride") or size, part.get("byteOffset", 0), self.buffer(view["buffer"])
        if begin + length > len(buffer) or count and at + stride * (count - 1) + size > length or stride < size:
            raise Damaged("a part of a buffer that is not there")
        return [list(struct.unpack_from(form, buffer, begin + at + stride * i)) for i in range(count)]

    def values(self, index, kind, is_index=False):
        accessor = picked(self.json["accessors"], index)
        code, count = CODES[accessor["componentType"]], accessor["count"]
        if accessor["type"] != kind or is_index and code not in "BHI":
            raise Damaged(f"accessor {index}")
        width = WIDTHS[kind]
        values = self.items(accessor, count, code, width) if "bufferView" in accessor else [[0] * width] * count
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            slots = self.items(sparse["indices"], sparse["count"], CODES[sparse["indices"]["componentType"]], 1)
            for (slot,), value in zip(slots, self.items(sparse["values"], sparse["count"], code, width)):
                picked(values, slot)
                values[slot] = value
        if accessor.get("normalized") and code != "f":
            most = {"b": 127, "B": 255, "h": 32767, "H": 65535, "I": 2 ** 32 - 1}[code]
            values = [[max(x / most, -1) for x in value] for value in values]
        return values

    def place(self, index):
        node = self.json["nodes"][index]
        mesh = picked(self.json["meshes"], node["mesh"])
        for primitive in mesh["primitives"]:
            attributes = primitive.get("attributes", {})
            points = self.values(attributes["POSITION"], "VEC3") if "POSITION" in attributes else []
            targets = primitive.get("targets", [])
            weights = node.get("weights", mesh.get("weights", [])) if targets else []
            if targets and weights and len(weights) != len(targets):
                raise Damaged("weights")
            for target, weight in zip(targets, weights):
                moves = self.values(target["POSITION"], "VEC3") if "POSITION" in target else [[0, 0, 0]] * len(points)
                if len(moves) != len(points):
                    raise Damaged("the number of a target's vertices")
                points = [[a + weight * b for a, b in zip(p, move)] for p, move in zip(points, moves)]
            if "skin" in node and points:
                points = self.skinned(points, attributes, picked(self.json["skins"], node["skin"]))
            else:
                points = [placed(self.world[index], p) for p in points]
            corners = [k for k, in self.values(primitive["indices"], "SCALAR", True)] if "indices" in primitive \
                else range(len(points))
            self.polygons += self.triangles([picked(points, k) for k in corners], primitive.get("mode", 4))

    def skinned(self, points, attributes, skin):
        if any(name in attributes for name in ("JOINTS_1", "WEIGHTS_1")):
            raise Unknown("more than four joints")
        joints, weights = self.values(attributes["JOINTS_0"], "VEC4"), self.values(attributes["WEIGHTS_0"], "VEC4")
        bones = skin["joints"]
        inverse = [rows(m) for m in self.values(skin["inverseBindMatrices"], "MAT4")] \
            if "inverseBindMatrices" in skin else [IDENTITY] * len(bones)
        if len(inverse) < len(bones) or not len(points) == len(joints) == len(weights):
            raise Damaged("the numbers of a skin")
        matrices = [product(self.world[bone], m) for bone, m in zip(bones, inverse)]
        out = []
        for p, four, weight in zip(points, joints, weights):
            if abs(sum(weight) - 1) > 1e-3:
                raise Unknown("weights that are not 1 together")
            moved = [(placed(picked(matrices, int(j)), p), w) for j, w in zip(four, weight) if w]
            out.append(tuple(sum(q[k] * w for q, w in moved) / sum(weight) for k in range(3)))
        return out

    @staticmethod
    def triangles(p, mode):
        if mode == 4:
            return [p[i:i + 3] for i in range(0, len(p) - 2, 3)]
        if mode == 5:
            return [[p[i + i % 2], p[i + 1 - i % 2], p[i + 2]] for i in range(len(p) - 2)]
        if mode == 6:
            return [[p[0], p[i], p[i + 1]] for i in range(1, len(p) - 1)]
        if mode not in range(4):
            raise Damaged(f"mode {mode}")
        return []


def polygons(data, files):
    return Reader(data, files).polygons
