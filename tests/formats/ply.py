"""A second reader of PLY, for comparison: in text, each element begins with a line."""

import struct

from measures import Damaged, Unknown, integer, number, picked

TYPES = {b"char": "b", b"uchar": "B", b"short": "h", b"ushort": "H", b"int": "i", b"uint": "I", b"float": "f", b"double": "d",
         b"int8": "b", b"uint8": "B", b"int16": "h", b"uint16": "H", b"int32": "i", b"uint32": "I", b"float32": "f",
         b"float64": "d"}


class Element:
    def __init__(self, name, count):
        self.name, self.count = name, count
        self.properties = []  # name, type, and the type of the length of a list or None


def header(data):
    """The format, the elements, and where the body begins."""
    lines, at, form, elements = [], 0, None, []
    while True:
        end = data.find(b"\n", at)
        if end < 0:
            raise Unknown("no line feeds in the header")
        lines.append(data[at:end].split())
        at = end + 1
        if lines[-1] == [b"end_header"]:
            break
    if lines[0] != [b"ply"]:
        raise Damaged("no magic")
    for words in lines[1:-1]:
        if not words or words[0] in (b"comment", b"obj_info"):
            continue
        if words[0] == b"format":
            form = words[1]
        elif words[0] == b"element":
            elements.append(Element(words[1], integer(words[2])))
        elif words[0] == b"property" and words[1] == b"list":
            elements[-1].properties.append((words[4], TYPES[words[3]], TYPES[words[2]]))
        elif words[0] == b"property":
            elements[-1].properties.append((words[2], TYPES[words[1]], None))
        else:
            raise Damaged(f"{words[0]!r} in the header")
    return form, elements, at


class Text:
    """An element begins with a line, and may go on in the next ones."""

    def __init__(self, data):
        self.lines = iter([line.split() for line in data.split(b"\n") if line.strip()])
        self.words = []

    def take(self):
        if not self.words:
            self.words = next(self.lines, None)
        if not self.words:
            raise Damaged("too few lines")
        return self.words.pop(0)

    def row(self, element):
        row = {}
        for name, _, length in element.properties:
            values = [number(self.take()) for _ in range(1 if length is None else integer(self.take()))]
            row[name] = values if length else values[0]
        if self.words:
            raise Damaged("a line with too many values")
        return row


class Binary:
    def __init__(self, data, order):
        self.data, self.order, self.at = data, order, 0

    def take(self, code, count):
        form = f"{self.order}{count}{code}"
        begin, self.at = self.at, self.at + struct.calcsize(form)
        if self.at > len(self.data):
            raise Damaged("too few bytes")
        return list(struct.unpack_from(form, self.data, begin))

    def row(self, element):
        row = {}
        for name, code, length in element.properties:
            if length:
                count = self.take(length, 1)[0]
                if not 0 <= count <= len(self.data) or count != int(count):
                    raise Damaged(f"a list of {count}")
                row[name] = self.take(code, int(count))
            else:
                row[name] = self.take(code, 1)[0]
        return row


def strip(corners):
    """The triangles of strips, which -1 parts."""
    run = []
    for corner in corners:
        run = [] if corner in (-1, 0xFFFFFFFF) else run + [corner]
        if len(run) > 2:
            yield [run[-2], run[-3], run[-1]] if len(run) % 2 == 0 else run[-3:]


def polygons(data, _=None):
    form, elements, begin = header(data)
    bodies = {b"ascii": lambda body: Text(body), b"binary_little_endian": lambda body: Binary(body, "<"),
              b"binary_big_endian": lambda body: Binary(body, ">")}
    if form not in bodies:
        raise Damaged(f"format {form}")
    body, vertices, faces = bodies[form](data[begin:]), [], []
    for element in elements:
        if element.count > len(data):
            raise Damaged(f"{element.count} elements")
        for _ in range(element.count if element.properties else 0):
            row = body.row(element)
            if element.name == b"vertex":
                vertices.append((row[b"x"], row[b"y"], row[b"z"]))
            elif element.name in (b"face", b"tristrips"):
                names = [name for name in (b"vertex_indices", b"vertex_index") if name in row]
                if len(names) != 1 or len(row) < len(element.properties):
                    raise Unknown("lists of vertices")
                corners = row[names[0]]
                faces += [corners] if element.name == b"face" else strip(corners)
    if any(k != int(k) for face in faces for k in face):
        raise Damaged("a part of a vertex")
    return [[picked(vertices, int(k)) for k in face] for face in faces]
