"""What is accepted as points."""

import unittest

import numpy as np

from sightline import PointGrid, as_points


class PointsTest(unittest.TestCase):
    def test_keeps_what_is_contiguous_without_copies(self):
        for dtype in ("f4", "f8"):
            given = np.zeros((5, 7, 3), dtype)
            points = as_points(given)
            self.assertEqual((points.shape, points.count, points.dtype), ((5, 7), 35, np.dtype(dtype)))
            self.assertTrue(np.shares_memory(points.positions, given))
            self.assertIs(as_points(points), points)

    def test_types(self):
        for value, expected in (([[0, 0, 1]], "f8"), (np.array([[0, 0, 1]], "i2"), "f8"),
                                (np.array([[0, 0, 1]], "f2"), "f4"), (np.array([[0, 0, 1]], ">f4"), "f4"),
                                (np.array([[0, 0, 1]], "longdouble"), "f8")):
            points = as_points(value)
            self.assertEqual(points.dtype, np.dtype(expected))
            np.testing.assert_array_equal(points.positions, [[0, 0, 1]])

    def test_a_max_distance_that_float32_would_change_makes_float64(self):
        point = np.zeros((1, 3), "f4")
        self.assertEqual(as_points(point, 0.5).dtype, np.float32)
        self.assertEqual(as_points(point, np.inf).dtype, np.float32)
        self.assertEqual(as_points(point, 0.1).dtype, np.float64)
        self.assertEqual(as_points(point, 0.1).position_type, np.float32)

    def test_broadcasts(self):
        points = as_points([0, 0, 0], np.ones((4, 1)), [1, 2, 3, 4, 5])
        self.assertEqual((points.shape, points.count), ((4, 5), 20))
        self.assertEqual([column.shape for column in points.columns()], [(20, 3), (20,), (20,)])
        some = points.some(np.array([1, 7]))
        self.assertEqual((some.shape, some.masks.tolist(), some.max_distance.tolist()), ((2,), [2, 3], [1, 1]))

    def test_grids(self):
        grid = PointGrid([1, 2, 3], [0.1, 0, 0], [0, 0.2, 0], 4, 3)
        self.assertEqual((grid.shape, grid.count), ((3, 4), 12))
        np.testing.assert_allclose(grid.positions()[2, 3], [1.3, 2.4, 3])
        deep = PointGrid([1, 2, 3], [0.1, 0, 0], [0, 0.2, 0], 4, 3, deep=[0, 0, 0.5], layers=2, max_distance=7, mask=9)
        self.assertEqual(deep.shape, (2, 3, 4))
        np.testing.assert_allclose(deep.positions()[1, 2, 3], [1.3, 2.4, 3.5])
        points = as_points(deep)
        self.assertEqual((points.shape, points.max_distance[0], points.masks[0]), ((2, 3, 4), 7, 9))
        np.testing.assert_array_equal(deep.some(np.array([23, 5])).positions, points.positions[[23, 5]])
        message = deep.message()
        self.assertEqual((message.columns, message.rows, message.layers, message.deep), (4, 3, 2, [0, 0, 0.5]))

    def test_refuses_with_what_is_wrong(self):
        grid = dict(origin=[0, 0, 0], across=[1, 0, 0], down=[0, 1, 0], columns=2, rows=2)
        for error, text, make in (
                (ValueError, r"points have the shape \(\.\.\., 3\), not \(2, 4\)", lambda: as_points(np.zeros((2, 4)))),
                (ValueError, r"not \(\)", lambda: as_points(3)),
                (ValueError, "broadcast", lambda: as_points(np.zeros((2, 3)), [1, 2, 3])),
                (ValueError, "32 bits", lambda: as_points(np.zeros((2, 3)), masks=-1)),
                (TypeError, "not bool", lambda: as_points(np.zeros((2, 3), bool))),
                (TypeError, "max_distance: real numbers", lambda: as_points(np.zeros((2, 3)), "far")),
                (TypeError, "Points have their own", lambda: as_points(as_points([0, 0, 0]), 1)),
                (TypeError, "PointGrid have their own", lambda: as_points(PointGrid(**grid), 1)),
                (ValueError, "origin has three", lambda: PointGrid(**{**grid, "origin": [0, 0]})),
                (ValueError, "across has three finite", lambda: PointGrid(**{**grid, "across": [0, np.inf, 0]})),
                (ValueError, "from 1 to 1048576, not 0", lambda: PointGrid(**grid, layers=0)),
                (ValueError, "32 bits", lambda: PointGrid(**grid, mask=1 << 32))):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                make()
