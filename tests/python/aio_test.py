"""The client for asyncio."""

import asyncio
import unittest

import brute
import numpy as np
import sightline
import sightline.aio


class AioTest(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        self.server = sightline.serve()
        self.addCleanup(self.server.close)

    async def asyncSetUp(self):
        self.client = sightline.aio.connect(self.server.endpoint)
        self.addAsyncCleanup(self.client.close)
        self.scene = await self.client.import_arrays("s", *brute.soup())
        self.rays = brute.rays(300)
        self.t, _ = brute.closest(*brute.soup(), self.rays[:, :3], self.rays[:, 3:])

    async def test_casts_at_the_same_time(self):
        answers = await asyncio.gather(*(self.scene.cast(self.rays) for _ in range(20)))
        for hits in answers:
            np.testing.assert_allclose(hits.t, self.t, rtol=1e-4)

    async def test_batches_of_an_asynchronous_generator(self):
        async def source():
            for part in np.array_split(self.rays, 6):
                await asyncio.sleep(0)
                yield part

        for batches in (source(), np.array_split(self.rays, 6)):
            async with self.scene.cast_batches(batches) as answers:
                t = [hits.t async for hits in answers]
            np.testing.assert_allclose(np.concatenate(t), self.t, rtol=1e-4)

    async def test_closest_points(self):
        points = self.rays[:, :3]
        table, _ = brute.distances(*brute.soup(), points)
        near = await self.scene.closest(points)
        np.testing.assert_allclose(near.distance, table.min(axis=1), rtol=1e-12)
        self.assertTrue((await self.scene.closest(points, 0.5, kind="count")).count.any())

        async def source():
            for part in np.array_split(points, 6):
                await asyncio.sleep(0)
                yield part

        for batches in (source(), np.array_split(points, 6)):
            async with self.scene.closest_batches(batches, 0.5) as answers:
                hit = [near.hit async for near in answers]
            np.testing.assert_array_equal(np.concatenate(hit), table.min(axis=1) <= 0.5)

    async def test_sides(self):
        scene = await self.client.import_arrays("box", *brute.box())
        points = np.random.default_rng(4).uniform(-1, 2, (60, 3))
        inside = ((points > 0) & (points < 1)).all(axis=1)
        np.testing.assert_array_equal(await scene.contains(points, side="winding"), inside)
        near = await scene.closest(points, fields=("signed", "votes"), side_rays=3)
        np.testing.assert_array_equal((near.signed < 0, near.votes), (inside, 3 * inside))
        async with scene.contains_batches(np.array_split(points, 6)) as answers:
            np.testing.assert_array_equal(np.concatenate([some async for some in answers]), inside)

    async def test_changes_and_watch(self):
        async with self.scene.batch() as batch:
            node = await self.scene.add(brute.box(), name="box")
        self.assertEqual(batch.applied.revision, 2)
        async with self.scene.update_stream("producer") as stream:
            await stream.set_transforms([node], np.eye(4)[None])
            self.assertEqual(await stream.flush(), 3)
        async with self.scene.watch(0) as changes:
            self.assertEqual([(await changes.__anext__()).revision for _ in range(3)], [1, 2, 3])
        self.assertEqual((await self.scene.info()).nodes, 2)
        self.assertEqual([scene.name for scene in await self.client.scenes()], [self.scene.name])

    async def test_changes_come_with_a_cast(self):
        move = sightline.updates.set_transforms([1], np.eye(4)[None])
        hits = await self.scene.cast(self.rays, apply=move)
        np.testing.assert_allclose(hits.t, self.t, rtol=1e-4)
        self.assertEqual((hits.revision, hits.applied.revision), (2, 2))
        async with self.scene.batch() as batch:
            node = await self.scene.add(brute.box(), name="box")
            near = await self.scene.closest(self.rays[:, :3], apply=batch)
            self.assertEqual((near.revision, near.applied, node.id), (3, batch.applied, 2))
        self.assertEqual((await self.scene.info()).revision, 3)

    async def test_trees_names_and_meshes(self):
        async with self.scene.batch():
            await self.scene.add(brute.box(), name="box")
        report = await self.scene.prefetch(under="box")
        self.assertEqual((report.triangles_done, report.revision), (12, 2))
        self.assertEqual((await self.scene.stats()).revision, 2)
        self.assertGreater(await self.scene.cool(), 0)
        found, all_found = await self.scene.find("box"), await self.scene.find_all("*")
        self.assertEqual(([node.name for node in all_found], found.id), (["mesh", "box"], 2))
        self.assertEqual((await self.scene.read_mesh("box")).faces.shape, (12, 3))
        scan = sightline.SphericalScan([0.5, 0.5, 0.5], 12, 8)
        hits = await self.scene.cast(scan, exclude="mesh")
        self.assertEqual((hits.shape, hits.hit.all()), ((8, 12), True))
        await self.scene.apply([sightline.updates.delete_node(2)])
        with self.assertRaises(sightline.NotFound):
            await self.scene.find("box")
        self.assertEqual((await self.client.server_info()).version, sightline.__version__)
        self.assertTrue((await self.client.read_log()).lines)
        self.assertIn(self.scene.name, repr(self.scene))

    async def test_cancelling_a_task_cancels_its_call(self):
        async def watching():
            async for _ in self.scene.watch():
                pass

        task = asyncio.create_task(watching())
        await asyncio.sleep(0.3)
        task.cancel()
        with self.assertRaises(asyncio.CancelledError):
            await asyncio.wait_for(task, 20)

        async def endless():
            while True:
                yield self.rays

        async def casting():
            async for _ in self.scene.cast_batches(endless()):
                pass

        with self.assertRaises(asyncio.TimeoutError):
            await asyncio.wait_for(casting(), 0.3)
        np.testing.assert_allclose((await self.scene.cast(self.rays)).t, self.t, rtol=1e-4)

    async def test_errors(self):
        with self.assertRaises(sightline.NotFound) as raised:
            await self.client.scene("none").cast(self.rays)
        self.assertEqual(raised.exception.reason, "SCENE_NOT_FOUND")
