"""Nodes by name and by pattern."""

import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest

DOWN = np.array([[x + 0.3, 0.4, 5, 0, 0, -1] for x in range(0, 8, 2)], "f8")  # a ray above each box


def at(x):
    return np.hstack([np.eye(3), [[x], [0], [0]]])


class NamesTest(ServerTest):
    def setUp(self):
        name = self.id().lower().rpartition(".")[2].replace("_", "-")
        self.scene = self.client.create_scene(name)
        self.other = sightline.connect(self.server.endpoint).scene(name)  # its names are not known to the first
        with self.scene.batch():
            house = self.scene.add(name="house")
            for number, word in enumerate(("window#1", "window#2", "door", "win*")):
                group = house.add(name=f"storey {number % 2}")
                setattr(self, f"node{number}", group.add(brute.box(), name=word, transform=at(2 * number)))

    def seen(self, **options):
        return self.scene.cast(DOWN, kind="any", **options).hit.tolist()

    def test_exclude(self):
        for words, seen in (("door", [1, 1, 0, 1]), (["door", self.node0], [0, 1, 0, 1]), ("win*", [1, 1, 1, 0]),
                            ("win?ow*", [0, 0, 1, 1]), ("window[#]1", [0, 1, 1, 1]), ("storey 1", [1, 0, 1, 0]),
                            ("/house/storey 1/*", [1, 0, 1, 0]), ("storey 1/win*", [1, 1, 1, 0]),
                            ("storey 1/wind*", [1, 0, 1, 1]), ("house", [0, 0, 0, 0]),
                            ("hous?/*/window*", [0, 0, 1, 1]), (self.scene.find("door"), [1, 1, 0, 1])):
            with self.subTest(words):
                self.assertEqual(self.seen(exclude=words), [bool(one) for one in seen])

    def test_under(self):
        self.assertEqual(self.seen(under="storey 1/window#2"), [False, True, False, False])
        self.assertEqual(self.scene.cast(DOWN, under="house", exclude="door").hit.tolist(), [True, True, False, True])
        near = self.scene.closest(DOWN[:, :3], under="door")
        self.assertEqual(set(near.name), {"door"})
        self.assertTrue(self.scene.contains([[4.5, 0.1, 0.1]], under="door").all())
        self.assertEqual(set(self.scene.render((20, 10), under="door").hits.node.ravel()) - {0}, {self.node2.id})

    def test_what_is_refused(self):
        for error, text, options in (
                (sightline.NotFound, "there is no node 'dor', did you mean 'door'", {"exclude": "dor"}),
                (sightline.NotFound, "no node 'x\\*'", {"exclude": "x*"}),
                (sightline.NotFound, "no node '/door'", {"under": "/door"}),
                (ValueError, "2 nodes are 'storey 0': name one by its id", {"under": "storey 0"}),
                (ValueError, "2 nodes are 'window\\*'", {"under": "window*"}),
                (ValueError, "not empty", {"under": ""}),
                (ValueError, "newest revision, 1: with revision=0", {"under": "door", "revision": 0})):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                self.seen(**options)
        with self.assertRaises(sightline.NotFound):
            self.client.scene("no-such-scene").find("door")

    def test_names_follow_the_scene(self):
        self.assertEqual(self.seen(exclude="window*"), [False, False, True, True])
        with self.other.batch():
            self.other.delete_node(self.node0.id)
            self.other.add(brute.box(), name="window#3", transform=at(0))
        self.assertEqual(self.seen(exclude="window*"), [False, False, True, True])
        self.assertEqual(self.seen(exclude="window#3"), [False, True, True, True])
        self.assertEqual(self.seen(exclude="door", revision=2), [True, True, False, True])
        changes = [sightline.updates.delete_node(self.node1.id)]
        self.assertEqual(self.seen(exclude="door", apply=changes), [True, False, False, True])

    def test_listing(self):
        nodes = self.scene.nodes()
        self.assertEqual([node.id for node in nodes], list(range(1, 10)))
        door = self.scene.find("door")
        self.assertEqual((door.name, door.id, nodes[door.parent - 1].name), ("door", self.node2.id, "storey 0"))
        np.testing.assert_array_equal(door.transform, at(4))
        self.assertEqual((door.mobility, door.mask, door.patched), ("static", 2 ** 32 - 1, False))
        self.assertEqual([node.name for node in self.scene.find_all("window*")], ["window#1", "window#2"])
        self.assertEqual(self.scene.find_all("nothing*"), [])
        with self.assertRaisesRegex(ValueError, "newest"):
            self.scene.nodes(revision=0)

    def test_many_nodes_with_gaps(self):
        with self.scene.batch():
            for number in range(1500):
                self.scene.add(name=f"n{number}")
        with self.scene.batch():
            for number in range(20, 1400):
                self.scene.delete_node(number)
        self.assertEqual(len(self.scene.nodes()), self.scene.info().nodes)
        self.assertEqual(self.scene.find("n1499").id, 1509)


if __name__ == "__main__":
    unittest.main()
