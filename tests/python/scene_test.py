"""Scenes, nodes, batches, streams of updates and watches."""

import types

import brute
import numpy as np
import sightline
from shared import ServerTest


def shifted(x):
    """A transform."""
    matrix = np.eye(4)
    matrix[0, 3] = x
    return matrix


DOWN = [[0.3, 0.4, 5, 0, 0, -1], [10.3, 0.4, 5, 0, 0, -1], [20.3, 0.4, 5, 0, 0, -1]]


class SceneTest(ServerTest):
    def setUp(self):
        self.box = brute.box()
        self.scene = self.client.create_scene(self.id().rpartition(".")[2].lower().replace("_", "-"), up_axis="z")

    def seen(self):
        """Which of the places at x = 0, 10, 20 has something."""
        return self.scene.cast(DOWN).hit.tolist()

    def test_scenes(self):
        made = self.scene_of(self.box, replace=True, meters_per_unit=0.01)
        info = made.info()
        self.assertEqual((info.triangles_unique, info.meters_per_unit, info.read), (12, 0.01, True))
        np.testing.assert_array_equal(info.bounds, [[0, 0, 0], [1, 1, 1]])
        self.assertIn(made.name, [scene.name for scene in self.client.scenes()])
        with self.assertRaises(sightline.AlreadyExists) as raised:
            self.client.import_arrays("test-scenes", *self.box)
        self.assertEqual(raised.exception.reason, "SCENE_EXISTS")
        made.delete()
        with self.assertRaises(LookupError):
            made.info()

    def test_meshes_that_are_refused(self):
        vertices, faces = self.box
        for error, text, mesh in ((ValueError, "vertex 99", (vertices, [[0, 1, 99]])),
                                  (ValueError, "negative", (vertices, [[0, 1, -1]])),
                                  (ValueError, "triangulate", (vertices, [[0, 1, 2, 3]])),
                                  (ValueError, "nothing to hit", (vertices, np.zeros((0, 3), int))),
                                  (ValueError, r"\(v, 3\)", (vertices[:, :2], faces)),
                                  (TypeError, "integers", (vertices, faces.astype(float))),
                                  (TypeError, "does not", "box")):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                self.scene.add(mesh)
        self.assertEqual(self.scene.info().revision, 0)

    def test_hierarchy(self):
        group = self.scene.add(name="group")
        node = group.add(types.SimpleNamespace(vertices=self.box[0], faces=self.box[1]), name="box",
                         transform=shifted(10))
        self.assertEqual(self.seen(), [False, True, False])
        group.set_transform(shifted(10))
        self.assertEqual(self.seen(), [False, False, True])
        node.set_transform(shifted(-10)[:3])
        self.assertEqual(self.seen(), [True, False, False])
        hits = self.scene.cast(DOWN, under=group)
        self.assertEqual(hits.name.tolist(), ["box", "", ""])
        self.assertFalse(self.scene.cast(DOWN, exclude=[group]).hit.any())
        with self.assertRaises(sightline.FailedPrecondition):
            group.delete()
        group.delete(subtree=True)
        self.assertEqual(self.scene.info().nodes, 0)

    def test_batch_is_one_revision(self):
        with self.scene.batch() as batch:
            group = self.scene.add(name="group", transform=shifted(10))
            node = group.add(self.box)
            with self.assertRaisesRegex(RuntimeError, "no id"):
                node.id
            self.scene.set_transforms([node], shifted(10)[None])
        self.assertEqual((batch.applied.revision, batch.applied.nodes), (1, (group.id, node.id)))
        self.assertEqual(self.seen(), [False, False, True])
        with self.assertRaisesRegex(ZeroDivisionError, "none"), self.scene.batch():
            node.delete()
            raise ZeroDivisionError("none of it happens")
        with self.assertRaises(sightline.Aborted), self.scene.batch(expected_revision=7):
            node.delete()
        self.assertEqual(self.scene.info().revision, 1)
        with self.scene.batch() as batch:
            pass
        self.assertIsNone(batch.applied)

    def test_changes_come_with_a_cast(self):
        with self.scene.batch() as batch:
            node = self.scene.add(self.box, transform=shifted(10))
            hits = self.scene.cast(DOWN, apply=batch)
            self.assertEqual((hits.hit.tolist(), hits.revision), ([False, True, False], 1))
            self.assertEqual((hits.applied, hits.applied.nodes), (batch.applied, (node.id,)))
            self.assertEqual(self.scene.info().revision, 1)
            self.scene.set_transforms([node], shifted(20)[None])
        self.assertEqual((batch.applied.revision, self.seen()), (2, [False, False, True]))
        for at in (0, 10, 20):
            hits = self.scene.cast(DOWN, kind="any", apply=sightline.updates.set_transforms([node], shifted(at)[None]))
            self.assertEqual(hits.hit.tolist(), [x == at for x in (0, 10, 20)])
            self.assertEqual(hits.applied.token, hits.token)
        near = self.scene.closest([[0.5, 0.5, 5]], apply=sightline.updates.set_transforms([node], shifted(0)[None]))
        self.assertEqual((near.distance.tolist(), near.applied.revision), ([4], 6))
        self.assertIsNone(self.scene.cast(DOWN).applied)

    def test_changes_that_a_cast_does_not_apply(self):
        node = self.scene.add(self.box)
        move = sightline.updates.set_transforms([node], shifted(10)[None])
        token = self.scene.cast(DOWN).token
        many = np.zeros((self.client.max_rays_per_request() + 1, 6))
        by_messages = sightline.connect(self.server.endpoint, use_segments=False)
        self.addCleanup(by_messages.close)
        grid = sightline.PointGrid(origin=[0, 0, 2], across=[1, 0, 0], down=[0, 1, 0], columns=2000, rows=2000)
        with self.client.create_scene("of-others").batch() as others:
            for text, asking in (("kind='all'", lambda: self.scene.cast(DOWN, kind="all", apply=move)),
                                 ("in a message", lambda: by_messages.scene(self.scene.name).cast(many, apply=move)),
                                 ("in a message", lambda: by_messages.scene(self.scene.name).closest(grid, apply=move)),
                                 ("iterator", lambda: next(self.scene.cast(iter([np.array(DOWN)]), apply=move))),
                                 ("revision", lambda: self.scene.cast(DOWN, revision=1, apply=move)),
                                 ("revision", lambda: self.scene.cast(DOWN, at_least=token, apply=move)),
                                 ("of-others", lambda: self.scene.cast(DOWN, apply=others))):
                with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                    asking()
        for error, asking in ((sightline.NotFound, lambda: sightline.updates.set_transforms([99], shifted(1)[None])),
                              (sightline.InvalidArgument, lambda: sightline.updates.set_transforms([node], np.full((1, 3, 4), np.inf)))):
            with self.assertRaises(error):
                self.scene.cast(DOWN, apply=asking())
        with self.assertRaises(sightline.Aborted), self.scene.batch(expected_revision=7) as batch:
            node.set_transform(shifted(10))
            self.scene.cast(DOWN, apply=batch)
        self.assertEqual((self.scene.info().revision, self.seen()), (1, [True, False, False]))
        with self.scene.batch(expected_revision=1) as batch:
            node.set_transform(shifted(10))
            self.assertEqual(self.scene.cast(DOWN, apply=batch).revision, 2)
            node.set_transform(shifted(20))
        self.assertEqual(batch.applied.revision, 3)

    def test_far_from_the_origin(self):
        far = np.array([4e6, 5e6, 0])
        vertices = self.box[0] / 1000 + far
        with self.assertWarns(sightline.PrecisionWarning):
            self.scene.add((vertices, self.box[1]), mask=2)
        node = self.scene.add((vertices, self.box[1]), origin=far, mask=1)
        ray = [*(far + [0.0003, 0.0004, 5]), 0, 0, -1]
        np.testing.assert_allclose(self.scene.cast(ray, masks=1).t, 4.999, atol=1e-8)
        node.set_transform(shifted(1))
        self.assertFalse(self.scene.cast(ray, masks=1).hit)
        np.testing.assert_allclose(self.scene.cast(ray + np.array([1, 0, 0, 0, 0, 0]), masks=1).t, 4.999, atol=1e-8)

    def test_flat_nodes_are_there_and_not_hit(self):
        group = self.scene.add(name="group")
        group.add(self.box)
        for flat in (np.zeros((3, 4)), np.diag([1.0, 1, 0, 1]), np.diag([1, 1e-14, 1, 1]), np.ones((3, 4))):
            group.set_transform(flat)
            self.assertEqual(self.seen(), [False, False, False])
            self.assertEqual(self.scene.info().instances, 1)
            group.set_transform(shifted(10))
            self.assertEqual(self.seen(), [False, True, False])

    def test_mirrored_nodes_keep_their_outside(self):
        self.scene.add(self.box)
        outward = self.scene.cast(DOWN[0]).normal
        for mirror in (np.diag([-1.0, 1, 1, 1]), np.diag([1.0, -1, 1, 1]), np.diag([1.0, 1, -1, 1])):
            mirror[:3, 3] = np.where(np.diag(mirror)[:3] < 0, 1, 0) + [10, 0, 0]
            node = self.scene.add(self.box, transform=mirror)
            hits = [self.scene.cast(DOWN[1], cull=cull) for cull in (None, "back", "front")]
            np.testing.assert_array_equal([hit.t for hit in hits], [4, 4, 5])
            np.testing.assert_array_equal(hits[0].normal, outward)
            node.delete()

    def test_patch(self):
        node = self.scene.add(self.box, mobility="deforming")
        node.patch(self.box[0] + [10, 0, 0])
        self.assertEqual(self.seen(), [False, True, False])

    def test_bad_changes(self):
        node = self.scene.add(self.box)
        for transform in (np.eye(3), np.ones((4, 4)), [1, 2]):
            with self.assertRaises(ValueError):
                node.set_transform(transform)
        with self.assertRaises(sightline.InvalidArgument) as raised:
            node.set_transform(np.full((3, 4), np.nan))
        self.assertEqual(raised.exception.reason, "NOT_FINITE")
        with self.assertRaises(sightline.NotFound):
            self.scene.add(parent=99)

    def test_watch(self):
        node = self.scene.add(self.box, name="box")
        node.set_transform(shifted(10))
        node.patch([[5, 5, 5]], first=3)
        node.delete()
        changes = self.scene.watch(0)
        first, second, third, fourth = (next(changes) for _ in range(4))
        changes.close()
        self.assertEqual([change.revision for change in (first, second, third, fourth)], [1, 2, 3, 4])
        put, = first.updates
        self.assertEqual((put.node, put.name, put.parent, put.mask), (node.id, "box", 0, 0xFFFFFFFF))
        np.testing.assert_array_equal(second.updates[0].transforms, shifted(10)[None, :3])
        self.assertEqual((third.updates[0].first, third.updates[0].vertices.tolist()), (3, [[5, 5, 5]]))
        self.assertEqual(fourth.updates, [sightline.updates.DeleteNode(node.id, False)])

    def test_update_stream(self):
        node = self.scene.add(self.box)
        with self.scene.update_stream("producer") as stream:
            for x in range(50):
                stream.set_transforms([node], shifted(x)[None])
            stream.set_transforms([node], shifted(10)[None])
            self.assertEqual(stream.flush(), 52)
            stream.set_transforms([99], shifted(10)[None])
            with self.assertRaises(sightline.NotFound) as raised:
                stream.flush()
            self.assertEqual(raised.exception.reason, "NODE_NOT_FOUND")
        self.assertEqual(self.seen(), [False, True, False])
        with self.scene.update_stream("producer") as stream:
            self.assertEqual(stream.set_transforms([node], shifted(20)[None]), 53)
        self.assertEqual(self.seen(), [False, False, True])
        with self.assertRaisesRegex(RuntimeError, "closed"):
            stream.set_transforms([node], shifted(20)[None])

    def test_a_producer_is_taken_over(self):
        node = self.scene.add(self.box)
        first = self.scene.update_stream("producer")
        with self.scene.update_stream("producer"):
            with self.assertRaises(sightline.Aborted) as raised:
                first.set_transforms([node], shifted(1)[None])
                first.flush(timeout=20)
            self.assertEqual(raised.exception.reason, "PRODUCER_TAKEN_OVER")
        with self.assertRaises(sightline.NotFound):
            self.client.scene("none").update_stream("producer")

    def test_large_batches_go_in_parts(self):
        with self.scene.batch() as batch:
            for _ in range(3000):
                self.scene.add()
        nodes = list(batch.applied.nodes) * 10
        with self.scene.update_stream("producer") as stream:
            stream.set_transforms(nodes, np.tile(shifted(1), (len(nodes), 1, 1)))
            self.assertEqual(stream.flush(), 2)
        self.assertEqual(self.scene.nodes(nodes[:600])[599].transform.tolist(), shifted(1)[:3].tolist())

    def test_a_scene_of_trimesh(self):
        box = types.SimpleNamespace(vertices=self.box[0], faces=self.box[1])
        edges = [("world", "arm", {"matrix": shifted(10)}), ("arm", "hand", {"matrix": shifted(10), "geometry": "box"}),
                 ("world", "foot", {"geometry": "box"}), ("world", "line", {"geometry": "path"})]
        graph = types.SimpleNamespace(base_frame="world", to_edgelist=lambda: edges)
        source = types.SimpleNamespace(graph=graph, geometry={"box": box, "path": types.SimpleNamespace()})
        top = self.scene.add(source, name="robot")
        self.assertEqual(self.seen(), [True, False, True])
        self.assertEqual((self.scene.info().revision, self.scene.info().meshes), (1, 1))
        top.set_transform(shifted(-10))
        self.assertEqual(self.seen(), [False, True, False])
