"""Meshes that are added with an origin stay where they belong, however their nodes are moved, and by whom."""

import asyncio

import brute
import numpy as np
import sightline
import sightline.aio
from scene_test import shifted
from shared import ServerTest

ORIGIN = np.array([4e6, -5e6, 1e5])
STEPS = np.arange(5.0)  # where boxes are looked for, along x from ORIGIN


class OriginTest(ServerTest):
    def setUp(self):
        self.mesh = (brute.box()[0] * 0.5 + ORIGIN, brute.box()[1])
        name = self.id().rpartition(".")[2].replace("_", "-")
        self.scene = self.client.create_scene(name)
        self.node = self.scene.add(self.mesh, name="box", origin=ORIGIN, mobility="rigid")
        self.other = sightline.connect(self.server.endpoint)
        self.addCleanup(self.other.close)

    def seen(self, **options):
        """The steps at which there is something."""
        origins = ORIGIN + [0.2, 0.3, 9] + STEPS[:, None] * [1, 0, 0]
        hits = self.scene.cast(origins=origins, directions=[0, 0, -1], **options)
        np.testing.assert_allclose(hits.t[hits.hit], 8.5)
        return STEPS[hits.hit].tolist()

    def test_every_way_to_move_a_node(self):
        fresh = self.other.scene(self.scene.name)

        def batch(scene, node):
            with scene.batch():
                scene.set_transforms([node], shifted(1)[None])
                scene.set_transforms([node], shifted(2)[None])

        def stream(scene, node):
            with scene.update_stream(f"p{id(scene)}") as updates:
                updates.set_transforms([node], shifted(2)[None])

        def messages(scene, node):
            with scene.update_stream("messages", latest_wins=True) as updates:
                updates.send(sightline.updates.set_transforms([node], shifted(2)[None]))

        ways = {"node": lambda: self.node.set_transform(shifted(2)),
                "scene": lambda: self.scene.set_transforms([self.node], shifted(2)[None, :3]),
                "id": lambda: self.scene.set_transforms([self.node.id], shifted(2)[None]),
                "batch": lambda: batch(self.scene, self.node), "stream": lambda: stream(self.scene, self.node),
                "another client": lambda: fresh.set_transforms([self.node.id], shifted(2)[None]),
                "its batch": lambda: batch(fresh, self.node.id), "its stream": lambda: stream(fresh, self.node.id),
                "messages": lambda: messages(fresh, self.node.id)}
        for name, move in ways.items():
            with self.subTest(name):
                move()
                self.assertEqual(self.seen(), [2])
                self.node.set_transform(np.eye(4))
                self.assertEqual(self.seen(), [0])

    def test_asyncio(self):
        async def moves():
            async with sightline.aio.connect(self.server.endpoint) as client:
                scene = client.scene(self.scene.name)
                node = await scene.add(self.mesh, origin=ORIGIN)
                await scene.set_transforms([node], shifted(3)[None])
                seen = [self.seen()]
                async with scene.batch():
                    await scene.set_transforms([node], shifted(2)[None])
                seen.append(self.seen())
                async with scene.update_stream("aio") as stream:
                    await stream.set_transforms([node], shifted(1)[None])
                seen.append(self.seen())
                return seen

        self.assertEqual(asyncio.run(moves()), [[0, 3], [0, 2], [0, 1]])

    def test_a_node_that_is_made_in_a_batch(self):
        with self.scene.batch() as batch:
            group = self.scene.add(name="group")
            node = group.add(self.mesh, origin=ORIGIN, transform=shifted(1))
            after = self.scene.add(name="after")
            node.set_transform(shifted(3))
        self.assertEqual(self.seen(), [0, 3])
        self.assertEqual(batch.applied.nodes, (group.id, node.id, node.mesh_node.id, after.id))
        group.set_transform(shifted(-1))
        self.assertEqual(self.seen(), [0, 2])

    def test_what_hangs_below_it_does_not_shift(self):
        arm = self.node.add(transform=shifted(1))
        hand = arm.add((self.mesh[0], self.mesh[1]), origin=ORIGIN, name="hand", transform=shifted(1))
        self.assertEqual(self.seen(), [0, 2])
        hand.set_transform(shifted(2))
        self.assertEqual(self.seen(), [0, 3])
        np.testing.assert_allclose(hand.origin, ORIGIN, atol=4096)

    def test_what_hits_say(self):
        hits = self.scene.cast([*(ORIGIN + [0.2, 0.3, 9]), 0, 0, -1])
        self.assertEqual((int(hits.node), str(hits.name)), (self.node.mesh_node.id, "box"))
        self.assertEqual(self.seen(under=self.node), [0])
        self.assertEqual(self.seen(exclude=[self.node]), [])
        near = self.scene.add(brute.box(), origin=[0.5, 0.5, 0.5])
        self.assertIs(near.mesh_node, near)

    def test_copies(self):
        digest = self.scene.nodes([self.node.mesh_node])[0].mesh_digest
        self.scene.put(digest, origin=ORIGIN, transform=shifted(2))
        self.other.scene(self.scene.name).put(digest, origin=self.node.origin, transform=shifted(4))
        self.assertEqual(self.seen(), [0, 2, 4])

    def test_vertices_that_move(self):
        self.node.patch(self.mesh[0] + [1, 0, 0])
        self.assertEqual(self.seen(), [1])
        self.scene.patch_vertices([self.node], self.mesh[0] + [2, 0, 0])
        self.assertEqual(self.seen(), [2])
        with self.scene.update_stream("producer") as stream:
            stream.patch_vertices([self.node], self.mesh[0] + [3, 0, 0])
        self.assertEqual(self.seen(), [3])
        with self.assertRaisesRegex(sightline.SightlineError, "mesh"):
            self.scene.patch_vertices([self.node.id], self.mesh[0])
        with self.assertRaisesRegex(ValueError, "different points"):
            self.scene.patch_vertices([self.node, self.scene.add(brute.box())], self.mesh[0])

    def test_deleting(self):
        self.node.delete()
        self.assertEqual(self.scene.info().nodes, 0)
        node = self.scene.add(self.mesh, origin=ORIGIN)
        node.add(name="child")
        with self.assertRaises(sightline.FailedPrecondition):
            self.scene.delete_node(node)
        self.assertEqual(self.seen(), [0])
        self.scene.delete_node(node.id, subtree=True)
        self.assertEqual(self.scene.info().nodes, 0)

    def test_a_scene_of_one_mesh(self):
        scene = self.client.import_arrays("one-mesh", *self.mesh, origin=ORIGIN)
        self.scene = scene
        self.assertEqual(self.seen(), [0])
        self.other.scene("one-mesh").set_transforms([1], shifted(2)[None])
        self.assertEqual(self.seen(), [2])
