"""The second reader of each format that has one."""

import collada
import gltf
import ifc
import obj
import ply
import stl
from measures import Damaged, Measures, Unknown

POLYGONS = {"glb": gltf.polygons, "gltf": gltf.polygons, "obj": obj.polygons, "ply": ply.polygons, "stl": stl.polygons,
            "ifc": ifc.polygons}
COUNTED = {"glb", "gltf", "obj", "ply", "stl", "dae"}  # Of other formats, polygons may be cut into more triangles or fewer.
ENDINGS = {f".{ending}" for ending in COUNTED}


def measures(ending, data, files):
    """Of a file of these bytes; `files` has the bytes of the files beside it by their names, or None. Raises Unknown or Damaged."""
    try:
        if ending == "dae":
            return collada.measures(data)
        if ending in POLYGONS:
            return Measures(POLYGONS[ending](data, files))
    except (Unknown, Damaged):
        raise
    except Exception as error:  # whatever a damaged file does to it
        raise Damaged(f"{type(error).__name__}: {error}") from error
    raise Unknown(ending)


def import_flags(ending, data):
    """With which the command keeps the axes that a second reader has."""
    if ending == "dae":
        return ["--up", "z" if b"Z_UP" in data else "y", "--meters-per-unit", "1"]
    return ["--up", "z"] if ending == "ifc" else []
