"""A private server of the wheel, without a path to it, from the start to the first answer; then the drop-in classes."""

import os
import time

begin = time.monotonic()

import numpy as np  # noqa: E402
import sightline  # noqa: E402
from sightline.open3d_t import RaycastingScene  # noqa: E402
from sightline.trimesh_ray import RayMeshIntersector  # noqa: E402


class Box:
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])


os.environ["PATH"] = "/usr/bin:/bin"  # the commands that pip made are in neither
imported = time.monotonic()
server = sightline.serve()
box = server.client.import_arrays("box", Box.vertices, Box.faces)
hits = box.cast([[0.3, 0.4, 3, 0, 0, -1]])
answered = time.monotonic()
assert hits.t.tolist() == [2], hits.t
print(f"imports {imported - begin:.2f} s, serve() to the first answer {answered - imported:.2f} s")
server.close()

print("trimesh's class:", RayMeshIntersector(Box).intersects_any([[0.3, 0.4, 3], [9, 9, 9]], [[0, 0, -1], [0, 0, -1]]))
raycasting = RaycastingScene()
raycasting.add_triangles(Box.vertices.astype(np.float32), Box.faces.astype(np.uint32))
print("Open3D's class:", raycasting.cast_rays(np.array([[0.3, 0.4, 3, 0, 0, -1]], dtype=np.float32))["t_hit"])
