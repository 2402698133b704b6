"""Changes as values: they are what a watch tells, and what is applied."""

import dataclasses
import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest
from sightline import updates

AT_TEN = np.hstack([np.eye(3), [[10], [0], [0]]])


class UpdatesTest(ServerTest):
    def test_there_and_back(self):
        for change in (updates.put_node(-1, 7, "name", AT_TEN, "sha256:00/24", "deforming", 5), updates.put_node(3),
                       *updates.set_transforms([1, 2], np.stack([AT_TEN, AT_TEN])), updates.delete_node(4, True),
                       *updates.patch_vertices([5], 3, np.arange(6.0).reshape(2, 3))):
            again = updates.decode(updates.encode(change))
            self.assertIs(type(again), type(change))
            for name, value in vars(change).items():
                np.testing.assert_array_equal(getattr(again, name), value)

    def test_a_scene_follows_another(self):
        one, other = self.client.import_arrays("one", *brute.box()), self.client.import_arrays("other", *brute.box())
        changes = one.watch(one.info().revision)
        node = one.add(brute.box(), name="second", transform=AT_TEN, mask=3)
        node.set_transform(2 * AT_TEN)
        node.patch([[0, 0, 0.5]])
        node.delete()
        for _ in range(4):
            change = next(changes)
            made = [dataclasses.replace(one, node=-1) if isinstance(one, updates.PutNode) else one for one in change.updates]
            applied = other.apply(made)
            self.assertEqual((applied.revision, applied.replayed), (change.revision, False))
        changes.close()
        self.assertEqual([node.name for node in other.nodes()], [node.name for node in one.nodes()])

    def test_apply(self):
        scene = self.scene_of(brute.box())
        applied = scene.apply([updates.put_node(-1, 1, "group"), updates.put_node(-2, -1, "inner")], expected_revision=1)
        self.assertEqual(scene.find("group/inner").id, applied.nodes[1])
        with self.assertRaises(sightline.Aborted):
            scene.apply([updates.delete_node(1, True)], expected_revision=1)
        with self.assertRaisesRegex(TypeError, "sightline.updates, not dict"):
            scene.apply([{"delete_node": 1}])
        with scene.update_stream("p") as stream, self.assertRaisesRegex(TypeError, "not str"):
            stream.send(["delete"])

    def test_what_is_refused(self):
        for text, asking in (("mobility", lambda: updates.put_node(1, mobility="fast")),
                             ("32 bits", lambda: updates.put_node(1, mask=-1)),
                             ("shape", lambda: updates.put_node(1, transform=np.eye(3))),
                             ("not \\(2, 3, 4\\)", lambda: updates.put_node(1, transform=np.stack([AT_TEN] * 2)))):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                asking()


if __name__ == "__main__":
    unittest.main()
