"""What is accepted as rays."""

import unittest

import numpy as np

from sightline import as_rays


class RaysTest(unittest.TestCase):
    def test_keeps_contiguous_columns_without_copies(self):
        for dtype in ("f4", "f8"):
            origins, directions = np.zeros((5, 7, 3), dtype), np.ones((5, 7, 3), dtype)
            rays = as_rays(origins=origins, directions=directions)
            self.assertEqual(rays.shape, (5, 7))
            self.assertEqual(rays.dtype, np.dtype(dtype))
            self.assertTrue(np.shares_memory(rays.origins, origins))
            self.assertTrue(np.shares_memory(rays.directions, directions))

    def test_views_tables_of_any_strides(self):
        table = np.arange(96.0).reshape(6, 16)[::2, ::2]
        rays = as_rays(table)
        self.assertTrue(np.shares_memory(rays.origins, table))
        np.testing.assert_array_equal(rays.directions, table[:, 3:6])
        np.testing.assert_array_equal(rays.tmin, table[:, 6])
        np.testing.assert_array_equal(rays.tmax, table[:, 7])

    def test_types(self):
        lists = [[0, 0, 0, 1, 0, 0]]
        for value, expected in ((lists, "f8"), (np.array(lists, "i2"), "f8"), (np.array(lists, "u8"), "f8"),
                                (np.array(lists, "f2"), "f4"), (np.array(lists, ">f4"), "f4"),
                                (np.array(lists, ">f8"), "f8"), (np.array(lists, "longdouble"), "f8")):
            rays = as_rays(value)
            self.assertEqual(rays.dtype, np.dtype(expected))
            np.testing.assert_array_equal(rays.directions, [[1, 0, 0]])

    def test_bounds_that_float32_would_change_make_float64(self):
        ray = np.array([[0, 0, 0, 1, 0, 0]], "f4")
        self.assertEqual(as_rays(ray, tmax=0.5).dtype, np.float32)
        self.assertEqual(as_rays(ray, tmax=np.inf).dtype, np.float32)
        self.assertEqual(as_rays(ray, tmax=0.1).dtype, np.float64)

    def test_broadcasts(self):
        rays = as_rays(origins=[0, 0, 0], directions=np.ones((4, 5, 3)), tmax=np.ones((5,)), masks=[[1]] * 4)
        self.assertEqual((rays.shape, rays.count), ((4, 5), 20))
        self.assertEqual([column.shape for column in rays.columns() if column is not None],
                         [(20, 3), (20, 3), (20,), (20,)])

    def test_refuses_with_what_is_wrong(self):
        for error, text, arguments in (
                (ValueError, r"\(\.\.\., 6\) or \(\.\.\., 8\), not \(2, 7\)", {"rays": np.zeros((2, 7))}),
                (ValueError, r"not \(\)", {"rays": 3}),
                (ValueError, r"directions have the shape", {"origins": np.zeros((2, 3)), "directions": np.zeros((2, 2))}),
                (ValueError, "broadcast", {"origins": np.zeros((2, 3)), "directions": np.zeros((4, 3))}),
                (ValueError, "32 bits", {"rays": np.zeros((2, 6)), "masks": -1}),
                (TypeError, "not bool", {"rays": np.zeros((2, 6), bool)}),
                (TypeError, "not complex", {"rays": np.zeros((2, 6), complex)}),
                (TypeError, "their own tmin", {"rays": np.zeros((2, 8)), "tmin": 0}),
                (TypeError, "need origins", {"origins": np.zeros((2, 3))}),
                (TypeError, "either rays or", {"rays": np.zeros((2, 6)), "origins": np.zeros((2, 3))}),
                (TypeError, "not float64", {"rays": np.zeros((2, 6)), "masks": 0.5})):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                as_rays(**arguments)
