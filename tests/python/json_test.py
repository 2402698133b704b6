"""Calls in JSON, at the admin port, answer as gRPC does."""

import hashlib
import http.client
import json
import os
import pathlib
import random
import socket
import subprocess
import tempfile
import time
import unittest

import brute
import grpc
import numpy as np
import sightline
from google.protobuf import json_format
from sightline import _proto

SCENE = "projects/default/scenes/box"
TOKENS = {"writer": "write", "reader": "read"}
MOST_BODY = 1 << 20
RAYS = np.random.default_rng(7).random((500, 6)) - [0, 0, -4, 0.5, 0.5, 2]
# Every unary call that a small scene can show. None has a part that differs from one call to the next, unless it is in CHANGING.
ASKED = {
    "GetScene": {"name": SCENE},
    "ListScenes": {"parent": "projects/default"},
    "BatchGetNodes": {"scene": SCENE},
    "ReadMesh": {"scene": SCENE, "node": "1"},
    "ListDeferredCells": {"scene": SCENE},
    "GetSceneStats": {"scene": SCENE},
    "CoolScene": {"scene": SCENE},
    "FindMissingBlobs": {"digests": ["AA" * 21 + "AA="]},
    "GetUploadStatus": {"digest": "AA" * 21 + "AA="},
    "GetServerInfo": {},
    "ReadLog": {},
    "ApplyUpdates": {"scene": SCENE, "requestId": "once", "updates": [{"setTransforms": {"nodes": ["1"]}}]},
    "CreateScene": {"scene": {"name": SCENE}},
    "DeleteScene": {"name": "projects/default/scenes/none"},
}


class Connection(http.client.HTTPConnection):
    """To a Unix socket."""

    def __init__(self, path):
        super().__init__("localhost", timeout=30)
        self.path = str(path)

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


class Endpoint:
    """A server with calls in JSON; `tokens` says whether clients need one of TOKENS."""

    def __init__(self, case, *flags, tokens=False):
        folder = tempfile.TemporaryDirectory()
        case.addClassCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        if tokens:
            text = ""
            for name, role in TOKENS.items():
                digest = hashlib.sha256(f"secret-of-{name}".encode()).hexdigest()
                text += f'[[token]]\nname = "{name}"\nsha256 = "{digest}"\nrole = "{role}"\nscenes = [""]\n'
            (self.folder / "tokens.toml").write_text(text)
            flags += ("--tokens", "tokens.toml")
        server = subprocess.Popen([os.environ["SIGHTLINED"], "--listen", "127.0.0.1:0", "--port-file", "port", "--admin",
                                   "unix:admin", *flags], cwd=self.folder, stderr=subprocess.DEVNULL)
        case.addClassCleanup(server.wait)
        case.addClassCleanup(server.terminate)
        port = self.folder / "port"
        while not (port.exists() and port.read_text().strip()):
            if server.poll() is not None:
                raise RuntimeError("the server did not start")
            time.sleep(0.02)
        self.target = f"127.0.0.1:{port.read_text().strip()}"
        channel = grpc.insecure_channel(self.target)
        case.addClassCleanup(channel.close)
        self.channel = channel

    def ask(self, name, body, method="POST", **headers):
        """The code, the headers and the body of the answer."""
        headers = {"Content-Type": "application/json"} | {key.replace("_", "-"): value for key, value in headers.items()}
        connection = Connection(self.folder / "admin")
        try:
            data = body if isinstance(body, bytes) else json.dumps(body).encode()
            connection.request(method, f"/v1/json/{name}", data, headers)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def error(self, name, body, method="POST", **headers):
        """The HTTP status, and the code and reason of the error."""
        status, _, answer = self.ask(name, body, method, **headers)
        error = json.loads(answer)["error"]
        assert set(error) == {"code", "message", "reason"} and error["message"], error
        return status, error["code"], error["reason"]

    def by_grpc(self, name, body, token=None):
        """The message, or the name of the code."""
        method = _proto.methods[name]
        call = self.channel.unary_unary(method.path, method.request.SerializeToString, method.response.FromString)
        try:
            metadata = [("authorization", f"Bearer {token}")] if token else []
            return call(json_format.ParseDict(body, method.request()), timeout=30, metadata=metadata)
        except grpc.RpcError as error:
            return error.code().name


class JsonTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Endpoint(cls, "--json-calls")
        client = sightline.connect(cls.server.target, timeout=20)
        cls.addClassCleanup(client.close)
        client.import_arrays("box", *brute.box())

    def columns(self, kind, fields):
        import base64
        text = lambda part: base64.b64encode(np.ascontiguousarray(part).tobytes()).decode()
        return {"scene": SCENE, "kind": f"QUERY_KIND_{kind}", "fields": [f"HIT_FIELD_{field}" for field in fields],
                "rays": {"float64": True, "count": len(RAYS), "origins": text(RAYS[:, :3]),
                         "directions": text(RAYS[:, 3:])}}

    def assert_same(self, name, body, without=()):
        status, headers, answer = self.server.ask(name, body)
        expected = self.server.by_grpc(name, body)
        if isinstance(expected, str):
            self.assertEqual(json.loads(answer)["error"]["code"], expected)
            self.assertGreaterEqual(status, 400)
            return None
        self.assertEqual((status, headers["Content-Type"]), (200, "application/json"), answer)
        got = json_format.Parse(answer, _proto.methods[name].response())
        for message in (got, expected):
            for field in without:
                message.ClearField(field)
        # NaN is not equal to itself, and -0 is to 0: bytes are compared.
        self.assertEqual(got.SerializeToString(deterministic=True), expected.SerializeToString(deterministic=True))
        return got

    def test_casts_have_the_same_bits(self):
        for kind, fields in (("CLOSEST", ("T", "NODE", "PRIMITIVE", "BARYCENTRIC", "NORMAL")), ("ANY", ("HIT",)),
                             ("COUNT", ("COUNT",)), ("ALL", ("T",))):
            with self.subTest(kind):
                body = self.columns(kind, fields) | ({"maxHits": 4} if kind == "ALL" else {})
                got = self.assert_same("CastRays", body, without=["stats"])
                self.assertGreaterEqual(len(got.columns), len(fields))

    def test_points_have_the_same_bits(self):
        rays = self.columns("CLOSEST", ())["rays"]
        body = {"scene": SCENE, "points": {"float64": True, "count": len(RAYS), "positions": rays["origins"]}}
        self.assertTrue(self.assert_same("QueryPoints", body, without=["stats"]).columns)

    def test_every_unary_call_is_there(self):
        unary = {name for name, method in _proto.methods.items()
                 if not method.client_streaming and not method.server_streaming}
        self.assertEqual(unary, set(ASKED) | {"CastRays", "QueryPoints"})

    def test_other_calls_answer_the_same(self):
        for name, body in ASKED.items():
            with self.subTest(name):
                if name in ("GetServerInfo", "ReadLog", "GetSceneStats", "CoolScene"):  # tell of the server's work
                    status, _, answer = self.server.ask(name, body)
                    expected = self.server.by_grpc(name, body)
                    if isinstance(expected, str):
                        self.assertEqual(json.loads(answer)["error"]["code"], expected)
                    else:
                        self.assertEqual(status, 200, answer)
                        if name == "CoolScene":  # the second call has nothing to free
                            continue
                        got = json_format.Parse(answer, _proto.methods[name].response())
                        self.assertEqual([field.name for field, _ in got.ListFields()],
                                         [field.name for field, _ in expected.ListFields()])
                else:
                    self.assert_same(name, body)

    def test_scenes_are_made_and_deleted(self):
        name = "projects/default/scenes/made"
        self.assertEqual(self.server.ask("CreateScene", {"scene": {"name": name, "metersPerUnit": 0.1}})[0], 200)
        self.assertEqual(self.assert_same("GetScene", {"name": name}).scene.meters_per_unit, 0.1)
        self.assertEqual(self.server.ask("DeleteScene", {"name": name})[0], 200)
        self.assertEqual(self.server.error("GetScene", {"name": name}), (404, "NOT_FOUND", "SCENE_NOT_FOUND"))

    def test_what_is_no_request(self):
        bad = ("", "[]", "1", "{", '{"name": }', "{'name': \"x\"}", '{name: "x"}', '{"name": "x",}', '{"name": 1}', '{"nome": "x"}',
               '{"name": "x", "name": "x"}', '{"name": "x"} {}', '{"name": "\xff"}', '{"name": {"name": "x"}}',
               "[" * 100_000, '{"a":' * 40 + "1" + "}" * 40, '{"name": "\\ud800"}')
        for text in bad:
            with self.subTest(text[:40]):
                self.assertEqual(self.server.error("GetScene", text.encode("latin1")), (400, "INVALID_ARGUMENT", "BAD_JSON"))
        twice = b'{"scene": {"upAxis": "UP_AXIS_Y", "up_axis": "UP_AXIS_Z"}}'
        self.assertEqual(self.server.error("CreateScene", twice)[2], "BAD_JSON")

    def test_how_a_request_must_be_made(self):
        body = {"name": SCENE}
        for method in ("GET", "PUT", "DELETE", "OPTIONS"):
            self.assertEqual(self.server.error("GetScene", body, method)[2], "BAD_HTTP_METHOD")
            status, headers, _ = self.server.ask("GetScene", body, method)
            self.assertEqual((status, headers["Allow"]), (405, "POST"))
        for kind in ("text/plain", "application/x-www-form-urlencoded", "", "application/json; charset=latin1"):
            self.assertEqual(self.server.error("GetScene", body, Content_Type=kind)[0], 415)
        self.assertEqual(self.server.error("GetScene", body, Content_Encoding="gzip")[0], 415)
        self.assertEqual(self.server.ask("GetScene", body, Content_Type="application/json; charset=UTF-8")[0], 200)
        self.assertEqual(self.server.error("Nothing", body), (404, "NOT_FOUND", "NO_SUCH_CALL"))
        self.assertEqual(self.server.error("../GetScene", body), (404, "NOT_FOUND", "NO_SUCH_CALL"))
        for name in ("WatchScene", "Backup", "StreamCastRays"):
            self.assertIn(self.server.error(name, body)[0], (404, 501))
        self.assertEqual(self.server.error("GetScene", body, Origin="http://elsewhere")[:2], (403, "PERMISSION_DENIED"))
        self.assertEqual(self.server.error("GetScene", body, Host="attacker.example")[:2], (403, "PERMISSION_DENIED"))

    def test_timeouts(self):
        for wrong in ("5", "S", "-1S", "123456789S", "1h", "1 S", "0n"):
            self.assertEqual(self.server.error("GetScene", {"name": SCENE}, Grpc_Timeout=wrong)[2], "BAD_TIMEOUT")
        self.assertEqual(self.server.ask("GetScene", {"name": SCENE}, Grpc_Timeout="99999999H")[0], 200)
        self.assertEqual(self.server.error("GetScene", {"name": SCENE}, Grpc_Timeout="1n")[:2], (504, "DEADLINE_EXCEEDED"))

    def test_large_bodies(self):
        body = b'{"name": "' + SCENE.encode() + b'"}'
        self.assertEqual(self.server.ask("GetScene", body + b" " * (MOST_BODY - len(body)))[0], 200)
        for size in (MOST_BODY + 1, 8 * MOST_BODY):
            status, code, reason = self.server.error("GetScene", body + b" " * (size - len(body)))
            self.assertEqual((status, code, reason), (413, "RESOURCE_EXHAUSTED", "BODY_TOO_LARGE"))

    def test_who_sends_or_reads_nothing_holds_nobody_up(self):
        silent = []
        for _ in range(40):
            connection = Connection(self.server.folder / "admin")
            connection.connect()
            connection.sock.sendall(b"POST /v1/json/GetScene HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                                    b"Content-Length: 1000000\r\n\r\n{")
            silent.append(connection)
        for _ in range(5):
            self.assertEqual(self.server.ask("GetScene", {"name": SCENE})[0], 200)
        for connection in silent:
            connection.close()

    def test_mutated_bodies(self):
        chance = random.Random(46)
        originals = [json.dumps(self.columns("CLOSEST", ("T",))).encode()[-400:],
                     *(json.dumps(body).encode() for body in ASKED.values())]
        names = ["CastRays", *ASKED]
        for _ in range(400):
            at = chance.randrange(len(names))
            body = bytearray(originals[at])
            for _ in range(chance.randint(1, 4)):
                place = chance.randrange(len(body) + 1)
                piece = chance.choice([b"{", b"}", b"[", b"\"", b"\\u0000", b"1e999", b"null", b"\xff", b",", b":", b"NaN",
                                       bytes([chance.randrange(256)])])
                body[place:place + chance.randint(0, 3)] = piece
            status, _, answer = self.server.ask(names[at], bytes(body))
            self.assertIn(status, (200, 400, 403, 404, 409, 412, 413, 429, 501), body)
            if status != 200:
                self.assertTrue(json.loads(answer)["error"]["reason"], body)
        self.assertEqual(self.server.ask("GetScene", {"name": SCENE})[0], 200)


class JsonTokensTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Endpoint(cls, "--json-calls", tokens=True)

    def test_tokens_are_those_of_grpc(self):
        create = {"scene": {"name": SCENE}}
        for token, status in ((None, 401), ("wrong", 401), ("secret-of-reader", 403)):
            with self.subTest(token):
                headers = {"Authorization": f"Bearer {token}"} if token else {}
                got = self.server.error("CreateScene", create, **headers)
                self.assertEqual(got[0], status)
                self.assertEqual(got[1], self.server.by_grpc("CreateScene", create, token))
        self.assertEqual(self.server.error("CreateScene", create, Authorization="Bearer \xe9")[:2], (401, "UNAUTHENTICATED"))
        self.assertEqual(self.server.ask("CreateScene", create, Authorization="Bearer secret-of-writer")[0], 200)
        self.assertEqual(self.server.ask("GetScene", {"name": SCENE}, Authorization="Bearer secret-of-reader")[0], 200)
        self.assertEqual(self.server.ask("GetScene", {"name": SCENE})[1]["WWW-Authenticate"], "Bearer")


class JsonOffTest(unittest.TestCase):
    def test_there_are_none_unless_asked_for(self):
        status, headers, _ = Endpoint(type(self)).ask("GetScene", {"name": SCENE})
        self.assertEqual((status, headers["Allow"]), (405, "GET, HEAD"))

    def test_what_cannot_go_with_it_is_refused(self):
        for flags in ([], ["--admin", "127.0.0.1:0", "--tls-cert", "c", "--tls-key", "k", "--tls-client-ca", "a"]):
            ran = subprocess.run([os.environ["SIGHTLINED"], "--check-config", "--json-calls", *flags], capture_output=True,
                                 text=True, check=False)
            self.assertNotEqual(ran.returncode, 0)
            self.assertIn("--json-calls", ran.stdout + ran.stderr)


if __name__ == "__main__":
    unittest.main()
