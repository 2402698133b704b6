#!/usr/bin/env python3
"""The judge of the failure suite finds what it is there to find."""

import os
import sys

try:
    import numpy as np
except ImportError:
    if os.path.exists("/usr/bin/python3") and os.path.realpath(sys.executable) != os.path.realpath("/usr/bin/python3"):
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])
    print("skipped: there is no numpy")
    sys.exit(77)

import unittest
from types import SimpleNamespace

sys.dont_write_bytecode = True
import world
from truth import Truth

RAYS = {0: world.make_rays(0)}
NODES = np.arange(10, 10 + world.WRITERS * world.BOXES, dtype=np.uint64).reshape(world.WRITERS, world.BOXES)
FIRST = 1


def hits(sequences, revision):
    """What a server without faults answers when each writer's newest batch is that of `sequences`."""
    entries = world.State(sequences)._entries(RAYS[0])
    t = entries.min(axis=1)
    node = np.where(np.isinf(t), 0, NODES.ravel()[entries.argmin(axis=1)]).astype(np.uint64)
    return SimpleNamespace(revision=revision, t=t, node=node)


def now(sequences):
    return np.stack([world.transforms(writer, sequence) for writer, sequence in enumerate(sequences)])


class Judge(unittest.TestCase):
    def setUp(self):
        self.truth = Truth("scene", NODES, FIRST)
        self.truth.acknowledge(0, 1, 2, 2, "two")
        self.truth.acknowledge(1, 1, 3, 3, "three")
        self.truth.answer(0, hits([0, 0, 0, 0], 1), 0.0, 0)
        self.truth.answer(0, hits([1, 0, 0, 0], 2), 0.0, 0)
        self.truth.answer(0, hits([1, 1, 0, 0], 3), 0.0, 3)

    def judge(self, head=3, sequences=(1, 1, 0, 0)):
        verdict = self.truth.judge(RAYS, head, now(sequences))
        return verdict["lost"], verdict["wrong"]

    def test_nothing_is_found_where_nothing_is_wrong(self):
        self.assertEqual(self.judge(), (0, 0))

    def test_the_rays_hit_and_miss(self):
        missed = np.isinf(hits([0, 0, 0, 0], 1).t)
        self.assertTrue(0.1 < missed.mean() < 0.9)

    def test_an_answer_of_another_revision_is_wrong(self):
        self.truth.answer(0, hits([1, 0, 0, 0], 3), 0.0, 0)
        self.assertEqual(self.judge(), (0, 1))

    def test_a_hit_of_another_box_is_wrong(self):
        changed = hits([1, 1, 0, 0], 3)
        first = np.flatnonzero(~np.isinf(changed.t))[0]
        changed.node[first] = NODES[0, 0] if changed.node[first] != NODES[0, 0] else NODES[0, 1]
        self.truth.answer(0, changed, 0.0, 0)
        self.assertEqual(self.judge(), (0, 1))

    def test_a_hit_that_is_not_there_is_wrong(self):
        changed = hits([1, 1, 0, 0], 3)
        changed.t[np.flatnonzero(np.isinf(changed.t))[0]] = 0.5
        self.truth.answer(0, changed, 0.0, 0)
        self.assertEqual(self.judge(), (0, 1))

    def test_an_answer_from_before_its_token_is_wrong(self):
        self.truth.answer(0, hits([1, 0, 0, 0], 2), 0.0, 3)
        self.assertEqual(self.judge(), (0, 1))

    def test_an_answer_from_before_the_scene_is_wrong(self):
        self.truth.answer(0, hits([0, 0, 0, 0], 0), 0.0, 0)
        self.assertEqual(self.judge(), (0, 1))

    def test_a_batch_after_the_head_is_lost(self):
        self.assertGreater(self.judge(head=2, sequences=(1, 0, 0, 0))[0], 0)

    def test_boxes_that_went_back_are_a_loss(self):
        self.assertEqual(self.judge(sequences=(1, 0, 0, 0)), (1, 0))

    def test_a_revision_that_was_given_twice_is_a_loss(self):
        self.truth.acknowledge(2, 1, 3, 3, "three")
        self.assertGreater(self.judge()[0], 0)

    def test_a_batch_that_was_applied_twice_is_found(self):
        self.assertEqual(self.judge(head=4), (1, 0))

    def test_a_batch_whose_answer_was_lost_fills_the_gap(self):
        self.truth.acknowledge(2, 1, 5, 5, "five")
        self.truth.acknowledge(3, 1, 2, 5, "five")
        self.truth.answer(0, hits([1, 1, 0, 1], 4), 0.0, 0)
        self.truth.answer(0, hits([1, 1, 1, 1], 5), 0.0, 0)
        self.assertEqual(self.judge(head=5, sequences=(1, 1, 1, 1)), (0, 0))

    def test_a_batch_whose_answer_was_lost_may_be_nowhere(self):
        self.truth.acknowledge(3, 1, 2, 3, "three")
        self.assertGreater(self.judge()[0], 0)


unittest.main()
