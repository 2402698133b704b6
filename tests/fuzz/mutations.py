"""Ways to damage a scene file. Rough ones break most files; gentle ones change a file in its format's own terms, so that many stay readable.

Each takes a generator of random numbers and a bytearray that is not empty, which it changes.
"""

import json
import re
import struct

NUMBERS = [b"0", b"-1", b"4294967295", b"2147483648", b"99999999999999999999", b"1e308", b"1e-320", b"nan", b"-inf", b"0x7f"]
LENGTHS = [0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 1 << 24, 1 << 28]
NUMBER = re.compile(rb"(?<![\w.])-?\d+(\.\d+)?(e[-+]?\d+)?(?![\w.])")
TYPES = [b"char", b"uchar", b"short", b"ushort", b"int", b"uint", b"float", b"double"]


def places(rng, size, count):
    return [rng.randrange(size) for _ in range(count)]


def cut_off(rng, data):
    del data[rng.randrange(len(data)):]


def other_bytes(rng, data):
    for i in places(rng, len(data), rng.choice([1, 4, 30])):
        data[i] = rng.randrange(256)


def without_a_part(rng, data):
    i = rng.randrange(len(data))
    del data[i:i + rng.randrange(1, 2000)]


def part_twice(rng, data):
    i = rng.randrange(len(data))
    data[i:i] = data[i:i + rng.randrange(1, 2000)]


def noise(rng, data):
    i = rng.randrange(len(data))
    data[i:i] = rng.randbytes(rng.choice([1, 64, 3000]))


def other_numbers(rng, data):
    found = list(re.finditer(rb"-?\d+(\.\d+)?", data))
    for match in sorted(rng.sample(found, min(len(found), rng.choice([1, 3, 20]))), key=lambda m: -m.start()):
        data[match.start():match.end()] = rng.choice(NUMBERS)


def other_lengths(rng, data):
    for i in places(rng, max(1, len(data) - 4), rng.choice([1, 4])):
        data[i:i + 4] = struct.pack(rng.choice("<>") + "I", rng.choice(LENGTHS))


ROUGH = [cut_off, other_bytes, without_a_part, part_twice, noise, other_numbers, other_lengths]


def other_names(rng, data, canary):
    """The names of other files, outside of the folder. `canary` is the path of one that must stay unread."""
    outside = [canary, "../canary.bin", "../../../../../../etc/passwd", "/dev/zero", "file://" + canary, "."]
    found = list(re.finditer(rb'(?<=")[\w./%-]+\.\w{1,4}(?=")|(?<=mtllib )\S+', data))
    for match in sorted(rng.sample(found, min(len(found), 3)), key=lambda m: -m.start()):
        data[match.start():match.end()] = rng.choice(outside).encode()


def near(rng, text, others):
    """A number in place of one; `others` are some of the same file."""
    is_integer = re.fullmatch(rb"-?\d+", text)
    if rng.random() < 0.4:
        return rng.choice(others)
    if is_integer:
        return b"%d" % (int(text) + rng.choice([-1, 1, 1, -2, 2, 10, -int(text), -2 * int(text)]))
    return repr(float(text) * rng.choice([-1, 0, 0.5, 2, 1.001, 1000])).encode()


def numbers_near(rng, data):
    found = list(NUMBER.finditer(data))
    if not found:
        return
    at = rng.randrange(len(found))  # one place, as statements stand together
    chosen = {(at + k) % len(found) for k in range(rng.choice([1, 1, 1, 3]))}
    for match in sorted((found[k] for k in chosen), key=lambda m: -m.start()):
        is_integer = b"." not in match.group()
        others = [m.group() for m in rng.sample(found, min(len(found), 20)) if (b"." not in m.group()) == is_integer]
        data[match.start():match.end()] = near(rng, match.group(), others or [match.group()])


def lines_of(data, pattern):
    """Where the lines begin and end that have a match."""
    return [m.span() for m in re.finditer(rb"[^\n]*\n", data) if re.search(pattern, m.group())]


def other_lines(pattern):
    """Drops, doubles or swaps lines."""

    def change(rng, data):
        found = lines_of(data, pattern)
        if not found:
            return
        at = rng.randrange(len(found))
        begin, end = found[at]
        how = rng.choice(["drop", "double", "swap"])
        if how == "drop":
            del data[begin:end]
        elif how == "double":
            data[end:end] = data[begin:end]
        else:
            first, second = sorted([found[at], found[min(len(found) - 1, at + rng.choice([1, 1, 5]))]])
            if first != second:
                data[first[0]:second[1]] = data[slice(*second)] + data[first[1]:second[0]] + data[slice(*first)]

    return change


def other_words(pattern):
    """Drops, doubles, swaps or replaces words of a line."""

    def change(rng, data):
        found = lines_of(data, pattern)
        if not found:
            return
        begin, end = rng.choice(found)
        words = bytes(data[begin:end]).split() or [b""]
        a, b = places(rng, len(words), 2)
        how = rng.choice(["drop", "double", "swap", "replace"])
        if how == "drop":
            del words[a]
        elif how == "double":
            words.insert(b, words[a])
        elif how == "swap":
            words[a], words[b] = words[b], words[a]
        else:
            words[a] = rng.choice(bytes(data[slice(*rng.choice(found))]).split() or [b""])
        data[begin:end] = b" ".join(words) + b"\n"

    return change


def other_reference(pattern):
    """Puts one of the names that match in the place of another."""

    def change(rng, data):
        found = list(re.finditer(pattern, data))
        if found:
            match = rng.choice(found)
            data[match.start():match.end()] = rng.choice(found).group()

    return change


def moved(rng, data, begin):
    """Copies a few bytes from one place of the binary numbers from `begin` on to another."""
    size = rng.choice([1, 2, 4, 4, 12])
    if len(data) > begin + size:
        a, b = (rng.randrange(begin, len(data) - size) for _ in range(2))
        data[a:a + size] = data[b:b + size]


def numbers_moved(rng, data):
    moved(rng, data, 0)


def of_facets_moved(rng, data):
    moved(rng, data, 84)


def of_buffer_moved(rng, data):
    if len(data) > 16:
        moved(rng, data, struct.unpack_from("<I", data, 12)[0] + 28)


def ply_body(rng, data):
    begin = data.find(b"end_header\n") + 11
    if begin == 10 or begin == len(data):
        return
    # Vertices come first, as a rule: other numbers there leave a file that can be read.
    third = begin + (len(data) - begin) // 3
    end = rng.choice([len(data), third, third])
    body = data[begin:end]
    if b"ascii" not in data[:begin]:
        moved(rng, body, 0)
    elif end < len(data):
        numbers_near(rng, body)
    else:
        rng.choice([numbers_near, numbers_near, other_words(b""), other_lines(b"")])(rng, body)
    data[begin:end] = body


def facets(rng, data):
    """Drops, doubles or swaps facets of binary STL, with or without the right number of them."""
    count = (len(data) - 84) // 50
    if count < 2 or data.startswith(b"solid"):
        return
    at, other, how = 84 + 50 * rng.randrange(count), 84 + 50 * rng.randrange(count), rng.choice(["drop", "double", "swap", "count"])
    if how == "drop":
        del data[at:at + 50]
    elif how == "double":
        data[at:at] = data[at:at + 50]
    elif how == "swap":
        data[at:at + 50], data[other:other + 50] = data[other:other + 50], data[at:at + 50]
    if how == "count" or rng.random() < 0.7:
        data[80:84] = struct.pack("<I", max(0, (len(data) - 84) // 50 + (rng.choice([-1, 1]) if how == "count" else 0)))


def ply_type(rng, data):
    end = data.find(b"end_header")
    found = list(re.finditer(rb"\b(u?char|u?short|u?int|float|double)\b", data[:max(0, end)]))
    if found:
        match = rng.choice(found)
        data[match.start():match.end()] = rng.choice(TYPES)


def ply_count(rng, data):
    found = list(re.finditer(rb"(?<=element vertex )\d+|(?<=element face )\d+", data))
    if found:
        match = rng.choice(found)
        data[match.start():match.end()] = b"%d" % max(0, int(match.group()) + rng.choice([-1, 1]))


def parts_of(value):
    """All lists and objects in a document of JSON."""
    if isinstance(value, (dict, list)):
        yield value
        for child in value.values() if isinstance(value, dict) else value:
            yield from parts_of(child)


def other_value(rng, value):
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return max(0, value + rng.choice([-1, 1, 1, -4, 4, 12, -value])) if rng.random() < 0.8 else rng.randrange(value + 3)
    if isinstance(value, float):
        return value * rng.choice([-1, 0, 0.5, 2, 1.001, 1000])
    if isinstance(value, str) and value in ("SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"):
        return rng.choice(["SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"])
    return value


def change_json(rng, document):
    # Not the looks, which most of a document is about.
    sections = ["scene", "scenes", "nodes", "meshes", "skins", "accessors", "bufferViews", "buffers"]
    parts = [document] + [p for name in sections for p in parts_of(document.get(name, []))]
    part = rng.choice([p for p in parts if p] or [document])
    key = rng.choice(list(part) if isinstance(part, dict) else range(len(part)))
    how = rng.choice(["value", "value", "value", "drop", "double", "swap", "key"])
    if how == "value" or isinstance(part[key], (int, float)) and rng.random() < 0.5:
        part[key] = other_value(rng, part[key])
    elif how == "drop":
        del part[key]
    elif isinstance(part, list) and how == "double":
        part.insert(key, part[key])
    elif isinstance(part, list):
        other = rng.randrange(len(part))
        part[key], part[other] = part[other], part[key]
    elif how == "key":
        part[rng.choice(["mode", "byteOffset", "byteStride", "skin", "mesh", "normalized", "scale", "weights", "children"])] = \
            rng.choice([0, 1, 2, 5, 12, True, [1.0, 2.0, 0.5], [1]])
    else:
        other = rng.choice(list(part))
        part[key], part[other] = part[other], part[key]


def document_values(rng, data):
    """Changes the JSON of glTF, and writes it again. Its container has the right lengths."""
    binary = b""
    text = bytes(data)
    try:
        if data.startswith(b"glTF"):
            size = struct.unpack_from("<I", data, 12)[0]
            text, binary = bytes(data[20:20 + size]), bytes(data[20 + size:])
        document = json.loads(text)
        for _ in range(rng.choice([1, 1, 2])):
            change_json(rng, document)
        text = json.dumps(document).encode()
    except (ValueError, AttributeError, struct.error):
        return
    if data.startswith(b"glTF"):
        text += b" " * (-len(text) % 4)
        text = b"glTF" + struct.pack("<III4s", 2, 20 + len(text) + len(binary), len(text), b"JSON") + text + binary
    data[:] = text


GENTLE = {
    "glb": [document_values, document_values, of_buffer_moved],
    "gltf": [document_values],
    "obj": [numbers_near, numbers_near, other_lines(rb"^\s*[fv] "), other_lines(rb""), other_words(rb"^\s*f "), other_words(rb"^\s*v ")],
    "ply": [ply_body, ply_body, ply_body, ply_body, ply_body, ply_body, numbers_near, ply_type, ply_count, other_lines(rb"^(property|element|comment)"),
            other_words(rb"^(property|element)")],
    "stl": [facets, facets, of_facets_moved, numbers_near, other_lines(rb"vertex|facet|loop|solid"), other_words(rb"vertex|facet")],
    "dae": [numbers_near, numbers_near, other_reference(rb'(?<=")#[\w.:-]+(?=")'), other_lines(rb"<"),
            other_reference(rb'(?<=semantic=")\w+(?=")'), other_reference(rb'(?<=count=")\d+(?=")|(?<=stride=")\d+(?=")')],
    "ifc": [numbers_near, other_reference(rb"(?<=[(,])#\d+(?=[,)])"), other_lines(rb"^#"), other_reference(rb"(?<==)\s*IFC\w+(?=\()")],
}
OF_NUMBERS = [numbers_moved, other_bytes]  # of the files of numbers that a scene names
