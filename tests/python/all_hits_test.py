"""All hits of rays, however many: what one answer cannot list is asked for again."""

import asyncio
import types
import warnings

import numpy as np
import sightline.aio
from shared import ServerTest
from sightline.open3d_t import RaycastingScene
from sightline.trimesh_ray import RayMeshIntersector

UP = [0, 0, 1]


def layers(heights):
    """A triangle over the origin at each height."""
    heights = np.asarray(heights, float)
    corners = np.tile([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]], (len(heights), 1))
    corners[:, 2] = np.repeat(heights, 3)
    return corners, np.arange(3 * len(heights)).reshape(-1, 3)


class AllHitsTest(ServerTest):
    def rows(self, hits, ray=0):
        """(t, node, primitive) of each hit of a ray."""
        part = slice(int(hits.offset[ray]), int(hits.offset[ray + 1]))
        return list(zip(hits.t[part].tolist(), hits.node[part].tolist(), hits.primitive[part].tolist()))

    def test_many_layers_and_few(self):
        scene = self.scene_of(layers(np.arange(1, 40001) / 8))
        rays = np.array([[0, 0, 0, *UP], [50, 0, 0, *UP], [0, 0, 4990, *UP], [0, 0, -5, 0, 0, 2], [np.nan] * 6])
        hits = scene.cast(rays, kind="all")
        self.assertEqual(hits.count.tolist(), [40000, 0, 81, 40000, 0])
        np.testing.assert_array_equal(hits.count[:4], scene.cast(rays[:4], kind="count").count)
        np.testing.assert_array_equal(hits.t[:40000], np.arange(1, 40001) / 8)
        self.assertEqual(len(set(self.rows(hits, 3))), 40000)
        self.assertFalse(hits.cut_off.any())
        self.assertEqual(hits.invalid.tolist(), [False] * 4 + [True])
        self.assertEqual((hits.stats["hits_found"], hits.stats["rays_cut_off"], hits.stats["rays"]), (80081, 0, 5))
        np.testing.assert_allclose(hits.position[:, 2], rays[hits.ray, 2] + hits.t * rays[hits.ray, 5])

    def test_hits_at_one_distance_are_neither_lost_nor_doubled(self):
        scene = self.client.create_scene("ties")
        heights = np.repeat(np.arange(1, 401), 37)  # every page ends within some
        nodes = [scene.add(layers(heights)).id for _ in range(3)]
        hits = scene.cast([[0, 0, 0, *UP]], kind="all")
        expected = sorted((float(t), node, number) for node in nodes for number, t in enumerate(heights))
        self.assertEqual(self.rows(hits), expected)

    def test_more_at_one_distance_than_an_answer_lists(self):
        scene = self.scene_of(layers(np.r_[np.ones(20000), np.full(100, 2.0)]))
        with self.assertWarnsRegex(UserWarning, "1 rays have more than 16384 hits at one distance"):
            hits = scene.cast([[0, 0, 0, *UP], [0, 0, 1.5, *UP]], kind="all")
        self.assertEqual((hits.count.tolist(), hits.cut_off.tolist()), ([16384, 100], [True, False]))

    def test_bounds_masks_and_fields(self):
        scene = self.client.create_scene("bounds")
        scene.add(layers(np.arange(1, 30001)), mask=1, name="odd")
        scene.add(layers(np.arange(1, 30001) + 0.5), mask=2)
        rays = np.array([[0, 0, 0, *UP, 10.5, 29000]] * 2, "f4")
        for fields in (None, ("primitive", "name"), ("position", "t")):
            hits = scene.cast(rays, masks=[1, 3], kind="all", fields=fields)
            self.assertEqual(hits.count.tolist(), [29000 - 10, 2 * 28990])
            if fields and "t" not in fields:
                self.assertEqual(hits.name[0], "odd")
                with self.assertRaisesRegex(AttributeError, "t was not asked for"):
                    hits.t

    def test_max_hits(self):
        scene = self.scene_of(layers(np.arange(1, 30001)))
        for most in (1, 256, 16384, 16385, 25000, 29999, 30000, 50000):
            with self.subTest(most):
                hits = scene.cast([[0, 0, 0, *UP], [0, 0, 29990.5, *UP]], kind="all", max_hits=most, fields=("t",))
                self.assertEqual(hits.count.tolist(), [min(most, 30000), min(most, 10)])
                self.assertEqual(hits.cut_off.tolist(), [most < 30000, most < 10])
                np.testing.assert_array_equal(hits.t[:min(most, 30000)], np.arange(1, min(most, 30000) + 1))

    def test_batches_and_asyncio(self):
        scene = self.scene_of(layers(np.arange(1, 20001)))
        ray = np.array([[0, 0, 0, *UP]])
        self.assertEqual([len(hits) for hits in scene.cast(iter([ray, ray * 1, ray]), kind="all")], [20000] * 3)

        async def casting():
            async with sightline.aio.connect(self.server.endpoint) as client:
                return len(await client.scene(scene.name).cast(ray, kind="all"))

        self.assertEqual(asyncio.run(casting()), 20000)

    def test_in_place_of_other_classes(self):
        vertices, faces = layers(np.arange(1, 17001))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            scene = RaycastingScene(client=self.client)
            scene.add_triangles(vertices[:30000], faces[:10000])
            scene.add_triangles(vertices[30000:], faces[:7000])
            listed = scene.list_intersections([[0, 0, 0, *UP], [0, 0, 9000.5, *UP]])
            ray = RayMeshIntersector(types.SimpleNamespace(vertices=vertices, faces=faces), client=self.client)
            places, _, face = ray.intersects_location([[0, 0, 0]], [UP])
            self.assertEqual(len(ray.intersects_id([[0, 0, 0]], [UP], max_hits=20000)[0]), 17000)
        self.assertEqual(listed["ray_splits"].tolist(), [0, 17000, 25000])
        self.assertEqual(np.bincount(listed["geometry_ids"][:17000]).tolist(), [10000, 7000])
        np.testing.assert_array_equal(face, np.arange(17000))
        with self.assertWarnsRegex(UserWarning, "1 rays have more than max_hits=16999"):
            ray.intersects_id([[0, 0, 0]], [UP], max_hits=16999)
