"""The programs of docs/recipes: each runs as it is, and its answers are compared with formulas or brute force."""

import importlib.util
import io
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import brute
from shared import ServerTest

RECIPES = pathlib.Path(__file__).resolve().parents[2] / "docs" / "recipes"


def recipe(name):
    """The recipe as a module."""
    spec = importlib.util.spec_from_file_location(f"recipe_{name}", RECIPES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class ProgramsTest(unittest.TestCase):
    """Each as a user starts it, in a folder of its own. What it prints and writes."""

    EXPECTED = {
        "clearance": (" 90.0 degrees: 0.050 m to the post", ()),
        "cloud_to_mesh": ("50000 points, from -0.440 to +0.098 mm", ("deviations.ply",)),
        "game_tick": ("revision 11: ", ()),
        "inside_test": ("26729 of 100000 points are inside", ()),
        "lidar_scan": ("points of 11520 rays", ("cloud.npy",)),
        "line_of_sight": ("pairs see each other", ()),
        "moving_cars": ("points of 2048 rays, ", ()),
        "moving_object": ("forklift at ( 9.0,  0.0): body at 8.00 m", ()),
        "ouster_os1": ("above the floor, at x = 20.00 m", ("yard.ply",)),
        "signed_slice": ("segments, together 5.02 long; a true circle is 5.03", ("outline.npy", "signed.npy")),
        "sun_hours": ("21 December: 8.0 h south of the house, 0.0 h north of it", ()),
        "velodyne_vlp16": ("points of 28928 rays in 100.0 ms, z -0.", ("hall.las", "hall.pcd")),
        "viewshed": ("are seen from the summit", ("viewshed.npy", "viewshed.pgm")),
        "wall_thickness": ("high z: 0.200 by balls, 0.200 by rays", ()),
    }

    def test_run(self):
        self.assertEqual(sorted(self.EXPECTED), sorted(file.stem for file in RECIPES.glob("*.py")))
        for name, (line, files) in self.EXPECTED.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                ran = subprocess.run([sys.executable, str(RECIPES / f"{name}.py")], cwd=folder, capture_output=True,
                                     text=True)
                self.assertEqual(ran.returncode, 0, ran.stderr)
                self.assertIn(line, ran.stdout)
                self.assertEqual(sorted(file.name for file in pathlib.Path(folder).iterdir()), sorted(files))


class LidarScanTest(ServerTest):
    def test_ranges_in_a_room(self):
        lidar = recipe("lidar_scan")
        low, high = np.array([-3.0, -90.0, -2.0]), np.array([9.0, 4.0, 3.0])
        scene = self.scene_of(lidar.box(low, high))
        position, velocity = np.array([1.0, 0.25, 0.5]), np.array([10.0, -5.0, 0.0])
        hits = lidar.scan(scene, position, velocity)
        self.assertEqual(hits.t.shape, (720, 16))
        for column in range(0, 720, 7):
            origin = position + velocity * 0.1 * column / 720
            for beam, degrees in enumerate(np.linspace(-15, 15, 16)):
                azimuth, elevation = 2 * math.pi * column / 720, math.radians(degrees)
                ray = np.array([math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                                math.sin(elevation)])
                walls = [((high if d > 0 else low)[axis] - origin[axis]) / d for axis, d in enumerate(ray) if d]
                expected = min(walls) if min(walls) <= 80 else math.inf
                self.assertTrue(math.isclose(hits.t[column, beam], expected, rel_tol=1e-9), (column, beam))
        self.assertFalse(hits.hit.all())  # the far wall is out of range

    def test_what_is_too_near_hides_what_is_behind(self):
        lidar = recipe("lidar_scan")
        scene = self.client.create_scene("near-things")
        scene.add(lidar.box([-20, -20, -20], [20, 20, 20]), name="room")
        for name, low, high in (("west", [-0.3, -0.2, -1], [-0.1, 0.2, 1]), ("north", [-0.2, 0.49, -1], [0.2, 0.6, 1]),
                                ("south", [-0.2, -0.9, -1], [0.2, -0.7, 1]), ("lens", [0.001, -0.0005, -1], [0.2, 0.0005, 1])):
            scene.add(lidar.box(low, high), name=name)
        hits = lidar.scan(scene, [0, 0, 0])
        level = hits.t.shape[1] // 2
        expected = {0: (np.inf, ""), 180: (np.inf, ""), 360: (np.inf, ""), 540: (0.7, "south"), 90: (28.3, "room")}
        for column, (metres, name) in expected.items():
            self.assertAlmostEqual(hits.t[column, level], metres, delta=0.02)
            self.assertEqual((bool(hits.hit[column, level]), hits.name[column, level]), (bool(name), name))
        self.assertTrue((hits.t >= lidar.RANGE[0]).all())
        self.assertEqual(np.isfinite(hits.position[..., 0]).tolist(), hits.hit.tolist())


class VelodyneTest(ServerTest):
    def test_a_hall(self):
        recipe_of = recipe("velodyne_vlp16")
        sensor, path = recipe_of.vlp16(), recipe_of.corner(0.2)
        self.assertEqual((sensor.shape, sensor.elevations.tolist()), ((1808, 16), list(range(-15, 16, 2))))
        sweep = sensor.sweep(path)
        hits = recipe_of.room(self.client).cast(sweep.rays)
        self.assertTrue(hits.hit.all())
        for column in range(0, 1808, 53):
            for ring, laser in enumerate((0, 2, 4, 6, 8, 10, 12, 14, 1, 3, 5, 7, 9, 11, 13, 15)):
                time = 55.296e-6 * column + 2.304e-6 * laser
                turn = 2 / 3 * time  # of the car; the head turns the other way, from y on
                azimuth, elevation = math.pi / 2 - 2 * math.pi * time / 0.1 + turn, math.radians(-15 + 2 * ring)
                ray = [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
                origin = [3 * math.sin(turn), 3 - 3 * math.cos(turn), 1.8]
                walls = [((high if d > 0 else low) - o) / d for o, d, low, high in
                         zip(origin, ray, (-15, -10, 0), (15, 10, 6)) if d]
                self.assertAlmostEqual(hits.t[column, ring], min(walls), delta=1e-4)  # the way is a chord of 2 mm


class OusterTest(ServerTest):
    def test_a_yard(self):
        recipe_of = recipe("ouster_os1")
        sensor = recipe_of.os1()
        self.assertEqual(sensor.shape, (1024, 64))
        mast = recipe_of.lidar.Trajectory([0], [np.column_stack([np.eye(3), [0, 0, 3]])])
        hits = recipe_of.yard(self.client).cast(sensor.sweep(mast).rays)
        for column in range(0, 1024, 31):
            for row in range(0, 64, 5):
                head = -2 * math.pi * column / 1024
                azimuth = head - math.radians((3.164, 1.055, -1.055, -3.164)[row % 4])
                elevation = math.radians(16.611 - 33.222 * row / 63)
                x, y = math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth)
                at = 0.012163 * np.array([math.cos(head), math.sin(head)])
                wall = (20 - at[0]) / x if x > 0 else math.inf
                is_wall = math.isfinite(wall) and abs(at[1] + wall * y) <= 20 and 0 <= 3 + wall * math.sin(elevation) <= 8
                floor = -3 / math.sin(elevation) if elevation < 0 else math.inf
                on_floor = math.isfinite(floor) and max(abs(at + floor * np.array([x, y]))) <= 100
                expected = min(wall if is_wall else math.inf, floor if on_floor else math.inf)
                self.assertTrue(math.isclose(hits.t[column, row], expected if expected <= 120 else math.inf, rel_tol=1e-9),
                                (column, row))


class MovingCarsTest(ServerTest):
    def test_frames(self):
        moving = recipe("moving_cars")
        scene, cars = moving.street(self.client, detail=2)
        scanner = moving.Scanner(self.client, beams=16, columns=128)
        before = scene.info().revision
        houses = [([x, y, 0], [x + 13, y + 12, 6 + 3 * (number % 4)])
                  for number, x in enumerate(np.linspace(-120, 104, 15)) for y in (10, -22)]
        self.assertEqual(scene.info().triangles_instanced, 16 * 2 * 2 + 30 * 40 + 20 * 10)
        on_cars = 0
        for number in (0, 1, 2, 40):
            sweep, hits, _ = scanner.frame(scene, cars, number)
            before += 1
            self.assertEqual((hits.revision, hits.applied.revision), (before, before))
            origins, rays = (part.reshape(-1, 3).astype("f8") for part in (sweep.origins, sweep.directions))
            middles = moving.poses(number * 0.1)[:, :, 3]
            boxes = houses + [(middle + [-2.2, -0.9, 0.2], middle + [2.2, 0.9, 1.5]) for middle in middles]
            low, high = (np.array(ends, "f8") for ends in zip(*boxes))
            with np.errstate(divide="ignore"):
                first, second = ((ends - origins[:, None]) / rays[:, None] for ends in (low, high))
                road = -origins[:, 2] / rays[:, 2]
            enters, leaves = np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)
            t = np.where((enters <= leaves) & (enters > 0), enters, np.inf)
            ends = np.abs(origins + road[:, None] * rays)
            t = np.column_stack([t, np.where((road > 0) & (ends[:, 0] <= 120) & (ends[:, 1] <= 7), road, np.inf)])
            nearest = t.min(axis=1)
            nearest[nearest > 120] = np.inf
            is_car = (t.argmin(axis=1) // 30 == 1) & (t.argmin(axis=1) < 50) & np.isfinite(nearest)
            np.testing.assert_allclose(hits.t.reshape(-1), nearest, atol=1e-4)
            np.testing.assert_array_equal(np.isin(hits.node.reshape(-1), [car.id for car in cars]), is_car)
            on_cars += is_car.sum()
        self.assertGreater(on_cars, 100)


class GameTickTest(ServerTest):
    @staticmethod
    def blocked(start, line, own, middle, half):
        """Whether a line on the plan, less the shares at its ends, meets the sides of a square."""
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (middle - half - start) / line, (middle + half - start) / line
        enters, leaves = np.minimum(first, second).max(), np.maximum(first, second).min()
        return enters <= leaves and any(own <= t <= 1 - own for t in (enters, leaves))

    def test_lines_of_sight(self):
        game = recipe("game_tick")
        rng = np.random.default_rng(3)
        places = rng.uniform(1, game.HALL - 1, (20, 2))
        scene, agents, pillars = game.arena(self.client, places)
        pairs = np.array([(i, j) for i in range(20) for j in range(20) if i != j])
        for step in range(5):
            places = game.walk(rng, places)
            sees, revision = game.tick(scene, agents, places, pairs)
            self.assertEqual(revision, step + 2)
            squares = [(middle, 1.0) for middle in pillars] + [(middle, game.WIDTH / 2) for middle in places]
            for (a, b), seen in zip(pairs, sees):
                line = places[b] - places[a]
                own = game.WIDTH / max(np.linalg.norm(line), 2.5 * game.WIDTH)
                self.assertEqual(seen, not any(self.blocked(places[a], line, own, *square) for square in squares), (step, a, b))


class LineOfSightTest(ServerTest):
    def test_matrix(self):
        line_of_sight = recipe("line_of_sight")
        vertices, faces, roofs = line_of_sight.town(blocks=5)
        antennas = roofs + [0, 0, 2]
        sees = line_of_sight.sees(self.scene_of((vertices, faces)), antennas, antennas)
        first, second = np.nonzero(~np.eye(len(antennas), dtype=bool))
        crossed = brute.hits(vertices, faces, antennas[first], antennas[second] - antennas[first], tmax=1.0)
        np.testing.assert_array_equal(sees[first, second], np.isnan(crossed).all(axis=1))
        np.testing.assert_array_equal(sees, sees.T)
        self.assertTrue(0 < sees[first, second].mean() < 1)

    def test_what_stands_near_an_end_of_a_long_line(self):
        line_of_sight = recipe("line_of_sight")
        for at in (0.5, 99.5, 9999.5, 0.01):
            wall = ([[at, -1, -1], [at, 1, -1], [at, 1, 1], [at, -1, 1]], [[0, 1, 2], [0, 2, 3]])
            scene = self.client.import_arrays("near-an-end", *wall, replace=True)
            sees = line_of_sight.sees(scene, np.array([[0.0, 0.1, 0.2]]), np.array([[10000.0, 0.1, 0.2]]))
            self.assertFalse(sees.any(), at)


class ViewshedTest(ServerTest):
    def test_hills(self):
        viewshed = recipe("viewshed")
        heights = viewshed.hills(rows=20, columns=30, cell=50.0)
        vertices, faces = viewshed.terrain(heights, 50.0)
        seen = viewshed.viewshed(self.scene_of((vertices, faces)), heights, 50.0, 12, 7)
        eye = np.array([350.0, 600.0, heights[12, 7] + 1.7])
        targets = vertices + [0, 0, 0.1]
        crossed = brute.hits(vertices, faces, np.broadcast_to(eye, targets.shape), targets - eye, tmax=1.0)
        np.testing.assert_array_equal(seen.ravel(), np.isnan(crossed).all(axis=1))
        self.assertTrue(0.1 < seen.mean() < 0.9)

    def test_nothing_is_seen_behind_a_ridge(self):
        viewshed = recipe("viewshed")
        heights = np.zeros((5, 30))
        heights[:, 10] = 10
        seen = viewshed.viewshed(self.scene_of(viewshed.terrain(heights, 10.0)), heights, 10.0, 2, 0)
        self.assertTrue(seen[:, :11].all())
        self.assertFalse(seen[:, 11:].any())


class SunHoursTest(ServerTest):
    def test_sun(self):
        sun = recipe("sun_hours").sun
        hours = np.arange(0, 24, 1 / 60)
        for latitude in (0, 48, -35, 60):
            for day in (81, 172, 355):
                declination = math.radians(23.45) * math.sin(2 * math.pi * (284 + day) / 365)
                to_sun = sun(latitude, day, hours)
                np.testing.assert_allclose(np.linalg.norm(to_sun, axis=1), 1)
                noon = math.degrees(math.asin(to_sun[12 * 60, 2]))
                self.assertAlmostEqual(noon, 90 - abs(latitude - math.degrees(declination)), places=6)
                sunset = math.degrees(math.acos(-math.tan(math.radians(latitude)) * math.tan(declination)))
                self.assertAlmostEqual((to_sun[:, 2] > 0).mean() * 24, 2 * sunset / 15, delta=2 / 60)
        self.assertGreater(sun(48, 172, 8)[0], 0)  # the morning's sun is in the east

    def test_behind_a_long_wall(self):
        sun_hours = recipe("sun_hours")
        wall = ([[-1e4, 0, 0], [1e4, 0, 0], [1e4, 0, 5], [-1e4, 0, 5]], [[0, 1, 2], [0, 2, 3]])
        distances = np.array([1.0, 3.0, 6.0, 12.0])
        points = np.column_stack([0 * distances, distances, 0 * distances])  # north of it
        for day in (81, 172, 355):
            hours = sun_hours.sun_hours(self.client.import_arrays(f"wall-{day}", *wall), points, 48, day)
            step = sun_hours.MINUTES / 60
            for distance, sunny in zip(distances, hours):
                expected = 0.0
                for _, north, up in sun_hours.sun(48, day, np.arange(step / 2, 24, step)):
                    if up > 0 and not (north < 0 and up / -north * distance < 5):
                        expected += step
                self.assertAlmostEqual(sunny, expected)


class InsideTestTest(ServerTest):
    def test_torus(self):
        inside_test = recipe("inside_test")
        scene = self.scene_of(inside_test.torus(ring=2.0, tube=0.7))
        points = np.random.default_rng(5).uniform([-3, -3, -1], [3, 3, 1], (20_000, 3))
        depth = 0.7 - np.hypot(np.hypot(points[:, 0], points[:, 1]) - 2.0, points[:, 2])
        clear = np.abs(depth) > 0.02  # the mesh is within 0.01 of the torus
        inside = scene.contains(points)
        np.testing.assert_array_equal(inside[clear], depth[clear] > 0)
        signed = scene.closest(points, fields=("signed",)).signed
        np.testing.assert_allclose(signed, -depth, atol=0.02)


class ClearanceTest(ServerTest):
    def test_angles(self):
        clearance = recipe("clearance")
        scene, arm = clearance.cell(self.client)
        before = scene.info().revision
        low, high = (np.array(end[:2]) for end in clearance.ARM)
        corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
        post = np.array([[-0.2, 1.55], [0.2, 1.9]])
        post_corners = np.array([[x, y] for x in post[:, 0] for y in post[:, 1]])

        def beside(points, first, last):
            """The least distance of points (n, 2) from a rectangle."""
            return np.linalg.norm(np.maximum(np.maximum(first - points, points - last), 0), axis=1).min()

        angles = np.radians(np.arange(-75, 130, 7.5))
        for angle, (metres, name, point) in zip(angles, clearance.clearances(scene, arm, angles)):
            turn = clearance.pose(angle)[:2, :2]
            expected = {"floor": 0.5, "wall": 1.8 - (corners @ turn.T)[:, 0].max(),
                        "post": min(beside(corners @ turn.T, *post), beside(post_corners @ turn, low, high))}
            nearest = min(expected.values())
            self.assertTrue(nearest - 1e-6 <= metres <= nearest + clearance.STEP, angle)
            if name != "post":
                self.assertAlmostEqual(metres, nearest, places=6)
            self.assertLess(expected[name], metres + 1e-6)
            self.assertLess(beside((point[:2] @ turn)[None], low, high), 1e-9)
        self.assertEqual(scene.info().revision, before + len(angles))


class SignedSliceTest(ServerTest):
    def test_ball(self):
        signed_slice = recipe("signed_slice")
        radius, step = 2.0, 0.05
        vertices, faces = signed_slice.ball(radius)
        inner = brute.distances(vertices, faces, np.zeros((1, 3)))[0].min()  # the mesh is between two spheres
        scene = self.scene_of((vertices, faces))
        for height in (0.0, 0.7, -1.9):
            grid = signed_slice.sightline.PointGrid(origin=[-2.4, 2.5, height], across=[step, 0, 0], down=[0.002, -step, 0],
                                                    columns=97, rows=101)
            signed = signed_slice.slice_of(scene, grid)
            self.assertEqual(signed.shape, (101, 97))
            away = np.linalg.norm(grid.positions(), axis=-1)
            self.assertTrue((away - radius - 1e-6 <= signed).all() and (signed <= away - inner + 1e-6).all())
            lines = signed_slice.outline(signed)
            away = np.linalg.norm(signed_slice.place(grid, lines), axis=-1)
            bend = (1.03 * step) ** 2 / 8 / (radius - 2 * step)  # how far distances along a step are from a straight line
            self.assertGreater(len(lines), 40)
            self.assertTrue((inner - bend <= away).all() and (away <= radius + bend).all())
            _, times = np.unique(lines.reshape(-1, 2), axis=0, return_counts=True)
            self.assertEqual(set(times), {2})  # each end is that of the next segment: the outline is closed

    def test_squares(self):
        outline = recipe("signed_slice").outline
        self.assertEqual(outline(np.array([[-1.0, 3.0], [-1.0, 1.0]])).tolist(), [[[0, 0.25], [1, 0.5]]])
        self.assertEqual(outline(np.ones((3, 4))).shape, (0, 2, 2))
        saddle = np.array([[-1.0, 1.0], [1.0, -1.0]])
        self.assertEqual(outline(saddle - 0.5).tolist(), [[[0, 0.75], [0.25, 1]], [[1, 0.25], [0.75, 0]]])
        self.assertEqual(outline(saddle + 0.5).tolist(), [[[0.25, 0], [0, 0.25]], [[0.75, 1], [1, 0.75]]])


class WallThicknessTest(ServerTest):
    def test_walls(self):
        walls = recipe("wall_thickness")
        part, (points, side) = walls.hollow_box(), walls.points_outside(5000)
        expected = walls.WALLS.ravel()[side]
        away = np.minimum(points, walls.OUTER - points)
        away[np.arange(5000), side % 3] = np.inf
        over_cavity = ((points >= walls.WALLS[0]) & (points <= walls.OUTER - walls.WALLS[1]))
        over_cavity[np.arange(5000), side % 3] = True
        clear = over_cavity.all(axis=1)
        rays = walls.thickness(part, points, method="ray", client=self.client)
        np.testing.assert_allclose(rays[clear], expected[clear], rtol=1e-5)
        balls = walls.thickness(part, points, client=self.client)
        clear &= away.min(axis=1) >= expected / 2
        self.assertGreater(clear.mean(), 0.5)
        np.testing.assert_allclose(balls[clear], expected[clear], rtol=1e-4)
        at_edge = away.min(axis=1) < 0.1  # half of the thinnest wall
        np.testing.assert_allclose(balls[at_edge], 2 * away.min(axis=1)[at_edge], atol=1e-4)
        outside = walls.thickness(part, points, exterior=True, client=self.client)
        self.assertTrue(np.isinf(outside).all())


class CloudToMeshTest(ServerTest):
    def test_deviations(self):
        cloud = recipe("cloud_to_mesh")
        points = cloud.scan(5000)
        scene = self.scene_of(cloud.part())
        errors = cloud.error_at(points[:, 0], points[:, 1])
        self.assertTrue(errors.min() < -0.4 < 0.05 < errors.max())
        np.testing.assert_allclose(cloud.deviations(scene, points), errors, atol=1e-12)

    def test_ply(self):
        cloud, file = recipe("cloud_to_mesh"), io.BytesIO()
        cloud.write_ply(file, [[1, 2, 3], [4, 5, 6], [7, 8, 9], [0, 0, 0]], np.array([0, 0.5, -9, 0.25]))
        header, _, rows = file.getvalue().partition(b"end_header\n")
        self.assertIn(b"element vertex 4\n", header)
        rows = np.frombuffer(rows, [("xyz", "<f4", 3), ("rgb", "u1", 3)])
        self.assertEqual(rows["xyz"][:2].tolist(), [[1, 2, 3], [4, 5, 6]])
        self.assertEqual(rows["rgb"].tolist(), [[255, 255, 255], [255, 0, 0], [0, 0, 255], [255, 128, 128]])


class MovingObjectTest(ServerTest):
    def test_distances(self):
        moving_object = recipe("moving_object")
        scene, forklift = moving_object.hall(self.client)
        before = scene.info().revision
        path = [(12, 3, 0), (10, 0.5, 0), (9, -0.5, 0), (8, -0.7, 0), (7, 0.9, math.pi / 2), (6, 1.1, math.pi / 2)]
        expected = [(20, "wall"), (9, "body"), (8, "body"), (20, "wall"), (6.4, "body"), (20, "wall")]
        for (metres, name), answer in zip(expected, moving_object.drive(scene, forklift, path)):
            self.assertAlmostEqual(answer[0], metres, places=6)
            self.assertEqual(answer[1], name)
        changes = scene.watch(before)
        self.assertEqual([next(changes).revision for _ in path], [before + 1 + step for step in range(len(path))])
        changes.close()
