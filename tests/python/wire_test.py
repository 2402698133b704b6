"""Messages that are put together by hand are those that protobuf makes."""

import unittest

import numpy as np

from sightline import Points, Rays, _cast_codec, _proto, _wire, as_points, as_rays, errors


class WireTest(unittest.TestCase):
    def test_requests_are_read_by_protobuf(self):
        table = np.random.default_rng(1).random((10, 8)).astype("f4")
        rays = as_rays(table, masks=np.arange(10))
        head = _proto.CastRaysRequest(scene="s", max_hits=7).SerializeToString()
        data = _cast_codec.stream_request(300, _cast_codec.request_parts(head, rays, 2, 9))
        message = _proto.StreamCastRaysRequest.FromString(data)
        self.assertEqual((message.chunk, message.request.scene, message.request.max_hits), (300, "s", 7))
        sent = message.request.rays
        self.assertFalse(sent.float64)
        self.assertEqual(sent.count, 7)
        self.assertEqual(sent.origins, table[2:9, :3].tobytes())
        self.assertEqual(sent.directions, table[2:9, 3:6].tobytes())
        self.assertEqual(sent.tmin, table[2:9, 6].tobytes())
        self.assertEqual(sent.tmax, table[2:9, 7].tobytes())
        self.assertEqual(sent.masks, np.arange(2, 9, dtype="u4").tobytes())

    def test_points_are_read_by_protobuf(self):
        table = np.random.default_rng(1).random((10, 3))
        points = as_points(table, np.arange(10), np.arange(10))
        self.assertIsInstance(points, Points)
        head = _proto.QueryPointsRequest(scene="s", max_hits=7).SerializeToString()
        data = _cast_codec.stream_request(300, _cast_codec.request_parts(head, points, 2, 9))
        message = _proto.StreamQueryPointsRequest.FromString(data)
        self.assertEqual((message.chunk, message.request.scene, message.request.max_hits), (300, "s", 7))
        sent = message.request.points
        self.assertEqual((sent.float64, sent.count, sent.positions), (True, 7, table[2:9].tobytes()))
        self.assertEqual(sent.max_distance, np.arange(2.0, 9).tobytes())
        self.assertEqual(sent.masks, np.arange(2, 9, dtype="u4").tobytes())

    def test_answers_to_points_have_the_numbers_of_casts(self):
        for kind in ("", "Stream"):
            rays, points = (getattr(_proto, f"{kind}{name}Response") for name in ("CastRays", "QueryPoints"))
            self.assertEqual([(field.number, field.type, field.label) for field in rays.DESCRIPTOR.fields],
                             [(field.number, field.type, field.label) for field in points.DESCRIPTOR.fields])

    def test_answers_of_protobuf_are_read(self):
        message = _proto.StreamCastRaysResponse(chunk=5)
        message.response.served.revision = 1 << 40
        message.response.served.token = "token"
        message.response.columns.add(field=_proto.enum_value("HIT_FIELD_T"), data=np.arange(3.0).tobytes())
        message.response.columns.add(field=_proto.enum_value("HIT_FIELD_NORMAL"), data=np.ones(9, "f4").tobytes())
        message.response.columns.add(field=99, data=b"of a later version")
        message.response.stats.hits = 2
        message.response.more = True
        chunk, answer = _cast_codec.stream_answer(message.SerializeToString())
        self.assertEqual((chunk, answer.revision, answer.token, answer.more), (5, 1 << 40, "token", True))
        np.testing.assert_array_equal(answer.rows("t", 3), [0, 1, 2])
        self.assertEqual(answer.rows("normal", 3).shape, (3, 3))
        self.assertEqual(answer.stats.hits, 2)
        with self.assertRaisesRegex(errors.Internal, "3 rows of t instead of 4"):
            answer.rows("t", 4)

    def test_names_are_rows_of_a_list(self):
        message = _proto.CastRaysResponse(names=["", "d\u00fcr", "wall"])
        message.columns.add(field=_proto.enum_value("HIT_FIELD_NAME"), data=np.array([2, 0, 1, 2], "u4").tobytes())
        answer = _cast_codec.answer(message.SerializeToString())
        self.assertEqual(answer.rows("name", 4).tolist(), ["wall", "", "d\u00fcr", "wall"])
        message.names.pop()
        with self.assertRaisesRegex(errors.Internal, "row 2 of 2 names"):
            _cast_codec.answer(message.SerializeToString())

    def test_broken_answers_are_errors(self):
        message = _proto.CastRaysResponse()
        message.columns.add(field=_proto.enum_value("HIT_FIELD_T"), data=np.arange(3.0).tobytes())
        whole = message.SerializeToString()
        for length in range(1, len(whole)):
            with self.subTest(length), self.assertRaises(errors.Internal):
                _cast_codec.answer(whole[:length]).rows("t", 3)
        for data in (b"\x0b", b"\x80" * 12, b"\x12\xff\xff\xff\xff\x0f"):
            with self.assertRaises(errors.Internal):
                _cast_codec.answer(data)

    def test_numbers(self):
        for value in (0, 1, 127, 128, 300, 1 << 32, (1 << 64) - 1):
            encoded = _wire.number_field(3, value)
            self.assertEqual(list(_wire.fields(memoryview(encoded))), [(3, value)])

    def test_no_rays(self):
        rays = as_rays(np.zeros((0, 6)))
        self.assertIsInstance(rays, Rays)
        request = _proto.CastRaysRequest.FromString(b"".join(_cast_codec.request_parts(b"", rays, 0, 0)))
        self.assertTrue(request.HasField("rays"))
