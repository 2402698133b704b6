"""Labels of nodes, and queries that select by them."""

import asyncio
import itertools
import unittest

import brute
import numpy as np
import sightline
import sightline.aio
from shared import ServerTest
from sightline import Label, updates

DOWN = np.array([[x + 0.3, 0.4, 5, 0, 0, -1] for x in range(0, 8, 2)], "f8")  # a ray above each box


def at(x):
    return np.hstack([np.eye(3), [[x], [0], [0]]])


class LabelsTest(ServerTest):
    """A house of two storeys, with two windows and a door, and a tree without labels."""

    def setUp(self):
        self.scene = self.client.create_scene(self.id().lower().rpartition(".")[2].replace("_", "-"))
        with self.scene.batch():
            house = self.scene.add(name="house", labels={"class": "IfcBuilding"})
            self.first = house.add(name="first", labels={"storey": "1"})
            self.second = house.add(name="second", labels={"storey": "2"})
            self.window = self.first.add(brute.box(), labels={"class": "IfcWindow", "étage": ""}, transform=at(0))
            self.upper = self.second.add(brute.box(), labels={"class": "IfcWindow"}, transform=at(2))
            self.door = self.first.add(brute.box(), labels={"class": "IfcDoor"}, transform=at(4))
            self.tree = self.scene.add(brute.box(), transform=at(6))

    def seen(self, **options):
        return self.scene.cast(DOWN, kind="any", **options).hit.astype(int).tolist()

    def test_exclude(self):
        for labels, seen in ((Label("class", "IfcWindow"), [0, 0, 1, 1]), (Label("étage"), [0, 1, 1, 1]),
                             (Label("class"), [0, 0, 0, 1]), (Label("class", ""), [1, 1, 1, 1]),
                             ([Label("storey", "2"), Label("class", "IfcDoor")], [1, 0, 0, 1]),
                             ([Label("storey", "2"), self.tree], [1, 0, 1, 0]),
                             ([Label("storey", "2"), "first"], [0, 0, 0, 1])):
            with self.subTest(labels):
                self.assertEqual(self.seen(exclude=labels), seen)

    def test_under(self):
        for labels, seen in ((Label("class", "IfcBuilding"), [1, 1, 1, 0]), (Label("storey", "1"), [1, 0, 1, 0]),
                             ([Label("storey", "2"), Label("class", "IfcDoor")], [0, 1, 1, 0]),
                             ([self.first, Label("class", "IfcWindow")], [1, 0, 0, 0]),
                             (["second", Label("class", "IfcDoor")], [0, 0, 0, 0])):
            with self.subTest(labels):
                self.assertEqual(self.seen(under=labels), seen)
        self.assertEqual(self.seen(under=Label("storey"), exclude=Label("class", "IfcWindow")), [0, 0, 1, 0])

    def test_every_query_has_them(self):
        doors = Label("class", "IfcDoor")
        self.assertEqual(set(self.scene.closest(DOWN[:, :3], under=doors).node), {self.door.id})
        self.assertFalse(self.scene.contains([[4.5, 0.1, 0.1]], exclude=doors).any())
        self.assertTrue(self.scene.contains([[4.5, 0.1, 0.1]], under=doors).all())
        self.assertEqual(set(self.scene.render((20, 10), under=doors).hits.node.ravel()) - {0}, {self.door.id})
        self.assertEqual(self.scene.prefetch(exclude=[Label("class"), self.tree]).meshes_total, 0)
        self.assertEqual(self.scene.prefetch(under=doors).meshes_total, 1)
        self.assertEqual(sum(hits.hit.sum() for hits in self.scene.cast(iter([DOWN, DOWN]), exclude=doors)), 6)
        every = self.scene.cast(np.array([[-1, 0.4, 0.2, 1, 0, 0]]), kind="all", under=Label("class", "IfcWindow"))
        self.assertEqual(set(every.node), {self.window.id, self.upper.id})

        async def first_seen():
            async with sightline.aio.connect(self.server.endpoint) as client:
                scene = client.scene(self.scene.name)
                return (await scene.cast(DOWN, kind="any", under=doors)).hit.tolist()
        self.assertEqual(asyncio.run(first_seen()), [False, False, True, False])

    def test_nodes_tell_them_and_a_put_replaces_them(self):
        before = self.scene.info().revision
        self.assertEqual(self.scene.nodes([self.window])[0].labels, {"class": "IfcWindow", "étage": ""})
        self.assertEqual(self.scene.nodes([self.tree])[0].labels, {})
        self.window.set_transform(at(0.1))
        self.assertEqual(self.scene.find("first").labels, {"storey": "1"})
        old = self.scene.nodes([self.window])[0]
        self.scene.apply([updates.put_node(old.id, old.parent, old.name, old.transform, old.mesh_digest,
                                           labels={"class": "IfcWall"})])
        self.assertEqual(self.scene.nodes([self.window])[0].labels, {"class": "IfcWall"})
        self.assertEqual(self.seen(exclude=Label("class", "IfcWindow")), [1, 0, 1, 1])
        self.assertEqual(self.seen(exclude=Label("class", "IfcWindow"), revision=before), [0, 0, 1, 1])
        changes = self.scene.watch(before)
        told = list(itertools.islice((one for change in changes for one in change.updates), 2))
        changes.close()
        self.assertEqual(told[1].labels, {"class": "IfcWall"})

    def test_what_is_refused(self):
        many = {f"k{number}": "" for number in range(65)}
        for error, text, labels in ((sightline.InvalidArgument, "65 labels, the limit is 64", many),
                                    (sightline.InvalidArgument, "65 bytes, the limit is 64", {"k" * 65: ""}),
                                    (sightline.InvalidArgument, "257 bytes, the limit is 256", {"k": "v" * 257}),
                                    (sightline.InvalidArgument, "empty key", {"": "v"}),
                                    (sightline.InvalidArgument, "control character", {"k": "a\nb"}),
                                    (sightline.InvalidArgument, "the limit is 4096",
                                     {f"k{number}": "v" * 256 for number in range(17)}),
                                    (TypeError, "dict of strings, not of 'k': 3", {"k": 3}),
                                    (TypeError, "dict of strings, not 'class'", "class"),
                                    (UnicodeEncodeError, "surrogates", {"k": "\ud800"})):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                self.scene.add(labels=labels)
        for text, chosen in (("exclude_labels: a label has an empty key", Label("")),
                             ("exclude_labels has 65 labels, the limit is 64", [Label("k")] * 65)):
            with self.subTest(text), self.assertRaisesRegex(sightline.InvalidArgument, text):
                self.seen(exclude=chosen)
        info = self.client.server_info()
        self.assertEqual((info.max_labels_per_node, info.max_label_key_bytes, info.max_label_value_bytes,
                          info.max_label_bytes_per_node, info.max_label_matches), (64, 64, 256, 4096, 64))
        self.assertIn("labels", info.features)

    def test_a_server_that_would_ignore_them_is_refused(self):
        self.assertEqual(self.seen(exclude=Label("class")), [0, 0, 0, 1])
        server = self.scene._session._server()
        features = list(server.features)
        features.remove("labels")
        server.features[:] = features
        with self.assertRaisesRegex(sightline.Unimplemented, "a version without labels"):
            self.seen(exclude=Label("class"))
        server.features.append("labels")


if __name__ == "__main__":
    unittest.main()
