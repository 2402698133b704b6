"""A second reader of OBJ, for comparison: polygons of the statements v and f."""

import re

from measures import Damaged, Unknown, integer, number, picked

# Of Wavefront's manual: what does not change polygons.
LOOKS = set(b"vt vn vp g o s mg usemtl mtllib usemap maplib bevel c_interp d_interp lod shadow_obj trace_obj ctech stech p l".split())


def polygons(data, _=None):
    vertices, faces = [], []
    text = re.sub(rb"\\(\r\n|\r|\n)", b" ", data.removeprefix(b"\xef\xbb\xbf"))
    for line in re.split(rb"\r\n|\r|\n", text):
        words = re.split(rb"(?:^|[ \t\v\f])#", line, maxsplit=1)[0].split()
        if not words:
            continue
        if words[0] == b"v":
            if len(words) < 4:
                raise Damaged(f"a vertex {line[:40]!r}")
            vertices.append(tuple(map(number, words[1:4])))
        elif words[0] == b"f":
            corners = [integer(word.split(b"/")[0]) for word in words[1:]]
            if 0 in corners:
                raise Damaged("vertex 0")
            faces.append([k - 1 if k > 0 else len(vertices) + k for k in corners])
        elif words[0] not in LOOKS:
            raise Unknown(words[0])
    return [[picked(vertices, k) for k in face] for face in faces]
