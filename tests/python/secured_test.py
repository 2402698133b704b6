"""Certificates and tokens."""

import hashlib
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

import brute
import sightline

TOKENS = {"writer": "write", "reader": "read"}


@unittest.skipUnless(shutil.which("openssl"), "needs openssl")
class SecuredTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        subprocess.run("openssl req -x509 -newkey ed25519 -nodes -subj /CN=localhost -addext subjectAltName=DNS:localhost "
                       "-days 2 -keyout key.pem -out cert.pem", shell=True, cwd=cls.folder, check=True,
                       capture_output=True)
        tokens = ""
        for name, role in TOKENS.items():
            (cls.folder / name).write_text(f"secret-of-{name}\n")
            digest = hashlib.sha256(f"secret-of-{name}".encode()).hexdigest()
            tokens += f'[[token]]\nname = "{name}"\nsha256 = "{digest}"\nrole = "{role}"\nscenes = [""]\n'
        (cls.folder / "tokens.toml").write_text(tokens)
        server = subprocess.Popen([os.environ["SIGHTLINED"], "--listen", "localhost:0", "--port-file", "port",
                                   "--tls-cert", "cert.pem", "--tls-key", "key.pem", "--tokens", "tokens.toml"],
                                  cwd=cls.folder, stderr=subprocess.DEVNULL)
        cls.addClassCleanup(server.wait)
        cls.addClassCleanup(server.terminate)
        port = cls.folder / "port"
        while not (port.exists() and port.read_text().strip()):
            if server.poll() is not None:
                raise RuntimeError("the server did not start")
            time.sleep(0.02)
        cls.endpoint = f"localhost:{port.read_text().strip()}"

    def connect(self, **options):
        client = sightline.connect(self.endpoint, timeout=20, **options)
        self.addCleanup(client.close)
        return client

    def test_a_token_by_file_and_by_value(self):
        writer = self.connect(tls_ca=self.folder / "cert.pem", token_file=self.folder / "writer")
        writer.import_arrays("box", *brute.box())
        reader = self.connect(tls_ca=self.folder / "cert.pem", token="secret-of-reader")
        self.assertTrue(reader.scene("box").cast([[0.3, 0.4, 5, 0, 0, -1]]).hit.all())
        with self.assertRaises(PermissionError) as raised:
            reader.delete_scene("box")
        self.assertIsInstance(raised.exception, sightline.PermissionDenied)

    def test_who_is_refused(self):
        for token in ("", "wrong"):
            with self.assertRaises(sightline.Unauthenticated):
                self.connect(tls_ca=self.folder / "cert.pem", token=token).scenes()

    def test_another_authority(self):
        subprocess.run("openssl req -x509 -newkey ed25519 -nodes -subj /CN=other -days 2 -keyout other.key -out other.pem",
                       shell=True, cwd=self.folder, check=True, capture_output=True)
        with self.assertRaises((sightline.Unauthenticated, sightline.Unavailable)):
            self.connect(tls_ca=self.folder / "other.pem", token="secret-of-reader").scenes()
