"""Rays that are float32 though they begin far from the origin are warned about, in every way to cast."""

import asyncio
import types
import warnings

import brute
import numpy as np
import sightline
import sightline.aio
from shared import ServerTest
from sightline import trimesh_proximity
from sightline.open3d_t import RaycastingScene
from sightline.trimesh_ray import RayMeshIntersector

FAR = np.array([388096.37, 3948996.81, 41.25])
TEXT = r"rays are float32 and begin up to 3\.95e\+06 from the origin, where float32 values are 0\.25 apart"
OF_POINTS = TEXT.replace("rays are float32 and begin", "points are float32 and lie")


class PrecisionTest(ServerTest):
    def setUp(self):
        self.box = (brute.box()[0] + FAR, brute.box()[1])
        self.scene = self.scene_of(self.box, origin=FAR)
        self.rays = np.array([[*(FAR + [0.3, 0.4, 5]), 0, 0, -1]] * 3)
        self.single = self.rays.astype("f4")

    def warned(self, call):
        """The warnings of a call."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            call()
        return [warning for warning in caught if issubclass(warning.category, sightline.PrecisionWarning)]

    def check(self, call, text=TEXT):
        caught = self.warned(call)
        self.assertEqual(len(caught), 1)
        self.assertRegex(str(caught[0].message), text)
        self.assertEqual(caught[0].filename, __file__)

    def test_casts(self):
        for kind in ("closest", "any", "count", "all"):
            self.check(lambda kind=kind: self.scene.cast(self.single, kind=kind))
        origins, directions = self.single[:, :3], self.rays[:, 3:]
        self.check(lambda: self.scene.cast(origins=origins, directions=directions, tmax=0.1))  # sent as float64
        self.check(lambda: self.scene.cast(self.single.astype(">f4")))

    def test_streams(self):
        self.check(lambda: list(self.scene.cast(iter([self.rays, self.single]))))

    def test_closest_points(self):
        text = OF_POINTS
        points = self.single[:, :3]
        for kind in ("closest", "any", "count", "all"):
            self.check(lambda kind=kind: self.scene.closest(points, kind=kind), text)
        self.check(lambda: self.scene.closest(points, 0.1), text)  # sent as float64
        self.check(lambda: list(self.scene.closest(iter([self.rays[:, :3], points]))), text)
        grid = sightline.PointGrid(self.single[0, :3], [1, 0, 0], [0, 1, 0], 2, 2)
        for precise in (self.rays[:, :3], grid):
            self.assertEqual(self.warned(lambda precise=precise: self.scene.closest(precise)), [])

    def test_other_types(self):
        for rays in (self.rays, self.rays.tolist(), np.round(self.rays).astype("i8")):
            self.assertEqual(self.warned(lambda rays=rays: self.scene.cast(rays)), [])
        near = self.client.import_arrays("near", *brute.box())
        half = np.array([[0.3, 0.4, 60000, 0, 0, -1]], "f2")
        self.check(lambda: near.cast(half), "rays are float16 and begin up to 6e[+]04 .* 32 apart")

    def test_rays_that_float32_holds_well(self):
        scene = self.client.import_arrays("small", *brute.box())
        for distance in (0, 1, 10):
            rays = np.array([[0.3, 0.4, distance, 0, 0, -1]], "f4")
            self.assertEqual(self.warned(lambda rays=rays: scene.cast(rays)), [])
        self.assertEqual(self.warned(lambda: self.client.create_scene("nothing").cast(self.single)), [])
        self.assertEqual(self.warned(lambda: scene.cast(np.full((2, 6), np.inf, "f4"))), [])
        self.assertEqual(self.warned(lambda: scene.cast(np.zeros((0, 6), "f4"))), [])

    def test_a_scene_that_grows(self):
        scene = self.client.import_arrays("growing", *self.box, origin=FAR)
        self.check(lambda: scene.cast(self.single))
        scene.add((self.box[0] + (brute.box()[0] - 0.5) * 1e6, self.box[1]))
        self.assertEqual(self.warned(lambda: scene.cast(self.single)), [])

    def test_asyncio(self):
        async def casts():
            async with sightline.aio.connect(self.server.endpoint) as client:
                await client.scene(self.scene.name).cast(self.single)

        async def batches():
            async with sightline.aio.connect(self.server.endpoint) as client:
                async for _ in client.scene(self.scene.name).cast_batches([self.single]):
                    pass

        for function in (casts, batches):
            self.check(lambda function=function: asyncio.run(function()))

    def test_a_line_of_a_program_warns_once(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("default")
            for _ in range(5):
                self.scene.cast(self.single)
            self.scene.cast(self.single)
        self.assertEqual(len(caught), 2)

    def test_in_place_of_open3d(self):
        scene = RaycastingScene(client=self.client)
        scene.add_triangles(*self.box)
        for name in ("cast_rays", "test_occlusions", "count_intersections", "list_intersections"):
            self.check(lambda name=name: getattr(scene, name)(self.single))
            self.assertEqual(self.warned(lambda name=name: getattr(scene, name)(self.rays)), [])
        for name in ("compute_occupancy", "compute_distance", "compute_signed_distance", "compute_closest_points"):
            self.check(lambda name=name: getattr(scene, name)(self.single[:, :3]), OF_POINTS)
            self.assertEqual(self.warned(lambda name=name: getattr(scene, name)(self.rays[:, :3])), [])
        eye = scene.create_rays_pinhole(60, center=FAR, eye=FAR + [0, 0, 5], up=[0, 1, 0], width_px=4, height_px=4)
        self.check(lambda: scene.cast_rays(eye))

    def test_in_place_of_trimesh(self):
        mesh = types.SimpleNamespace(vertices=self.box[0], faces=self.box[1])
        ray = RayMeshIntersector(mesh, client=self.client)
        for name in ("intersects_id", "intersects_location", "intersects_first", "intersects_any"):
            self.check(lambda name=name: getattr(ray, name)(self.single[:, :3], self.single[:, 3:]))
            self.assertEqual(self.warned(lambda name=name: getattr(ray, name)(self.rays[:, :3], self.rays[:, 3:])), [])
        self.check(lambda: ray.contains_points(self.single[:, :3]), OF_POINTS)
        places, _, _ = ray.intersects_location(self.rays[:, :3], self.rays[:, 3:])
        self.assertEqual(places.dtype, np.float64)

    def test_in_place_of_trimesh_proximity(self):
        mesh = types.SimpleNamespace(vertices=self.box[0], faces=self.box[1])
        query = trimesh_proximity.ProximityQuery(mesh, client=self.client)
        for ask in (query.on_surface, query.signed_distance, query.vertex):
            self.check(lambda ask=ask: ask(self.single[:, :3]), OF_POINTS)
            self.assertEqual(self.warned(lambda ask=ask: ask(self.rays[:, :3])), [])
        up = np.broadcast_to([0, 0, 1.0], (3, 3))
        for method in ("ray", "max_sphere"):
            for normals, text in ((None, OF_POINTS), (up, TEXT)):
                def ask(points):
                    return trimesh_proximity.thickness(mesh, points, False, normals, method, client=self.client)

                self.check(lambda: ask(self.single[:, :3]), text)
                self.assertEqual(self.warned(lambda: ask(self.rays[:, :3])), [])

    def test_warnings_of_meshes_name_the_program(self):
        self.check(lambda: self.scene.add(self.box), "vertices are kept as float32")
