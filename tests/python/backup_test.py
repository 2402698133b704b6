"""Backups and restores from Python, and between it and the command."""

import pathlib
import subprocess
import tempfile
import unittest

import brute
import numpy as np
import sightline
from shared import COMMAND
from sightline import _proto


class BackupTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.server = sightline.serve(data_dir=self.folder / "data")
        self.addCleanup(self.server.close)
        self.client = self.server.client
        self.scene = self.client.import_arrays("box", *brute.box())
        self.other = self.client.import_arrays("soup", *brute.soup())
        self.node = self.scene.add(brute.box(), name="second", transform=np.hstack([np.eye(3), [[5], [0], [0]]]))
        self.names = [self.scene.name, self.other.name]

    def seen(self):
        return self.scene.cast([[x, 0.4, 5, 0, 0, -1] for x in (0.3, 5.3, 10.3)], kind="any").hit.tolist()

    def test_there_and_back(self):
        told = []
        copied = self.client.backup(self.folder / "copy", progress=lambda done, total: told.append((done, total)))
        self.assertEqual([(one.name, one.base <= one.revision) for one in copied], [(name, True) for name in self.names])
        self.assertEqual(told[-1], ((self.folder / "copy/scenes.parts").stat().st_size, None))
        self.node.set_transform(np.hstack([np.eye(3), [[10], [0], [0]]]))
        self.assertEqual(self.seen(), [True, False, True])
        self.client.delete_scene("soup")
        restored = self.client.restore(self.folder / "copy")
        self.assertEqual([(one.name, one.revision) for one in restored], [(one.name, one.revision) for one in copied])
        self.assertEqual(self.seen(), [True, True, False])
        self.assertEqual(restored[0].token, self.scene.info().token)
        self.assertEqual(self.scene.find("second").id, self.node.id)
        self.assertEqual(self.other.info().triangles_unique, 200)

    def test_one_scene_and_one_revision(self):
        self.assertEqual([one.name for one in self.client.backup(self.folder / "copy", "box")], self.names[:1])
        self.client.delete_scene("soup")
        base = self.client.backup(self.folder / "again", "box")[0].base
        self.client.restore(self.folder / "copy", "box", revision=base)
        self.assertEqual(self.scene.info().revision, base)
        with self.assertRaises(sightline.OutOfRange):
            self.client.restore(self.folder / "copy", revision=99)
        with self.assertRaises(sightline.NotFound):
            self.client.restore(self.folder / "copy", "soup")
        with self.assertRaises(sightline.NotFound):
            self.client.backup(self.folder / "none", "soup")
        self.assertEqual(list((self.folder / "none").iterdir()), [])

    def test_what_is_refused(self):
        self.client.backup(self.folder / "copy")
        parts, sums = self.folder / "copy/scenes.parts", self.folder / "copy/SHA256SUMS"
        with self.assertRaisesRegex(sightline.FailedPrecondition, "BACKUP_NOT_EMPTY"):
            self.client.backup(self.folder / "copy")
        whole, line = parts.read_bytes(), sums.read_text()
        for bad in (whole[:-1], whole[:-9] + b"\0" + whole[-8:], b""):
            parts.write_bytes(bad)
            with self.assertRaisesRegex(sightline.DataLoss, "BACKUP_CORRUPT"):
                self.client.restore(self.folder / "copy")
        for bad in (b"\1\0\0", b"\xff\xff\xff\xff", b"\2\0\0\0\xff\xff"):  # sums that fit, parts that do not
            parts.write_bytes(bad)
            sums.write_text(subprocess.run(["sha256sum", "scenes.parts"], cwd=parts.parent, text=True, capture_output=True,
                                           check=True).stdout)
            with self.assertRaisesRegex(sightline.DataLoss, "BACKUP_CORRUPT"):
                self.client.restore(self.folder / "copy")
        parts.write_bytes(whole)
        sums.write_text(line)
        with self.assertRaises(FileNotFoundError):
            self.client.restore(self.folder / "nowhere")
        with sightline.serve() as memory, self.assertRaises(sightline.FailedPrecondition):
            memory.client.backup(self.folder / "memory")
        self.assertEqual(self.seen(), [True, True, False])
        self.assertEqual(len(self.client.restore(self.folder / "copy")), 2)

    def test_meshes_in_files_of_their_own(self):
        self.client.backup(self.folder / "copy")
        parts, sums = self.folder / "copy/scenes.parts", self.folder / "copy/SHA256SUMS"
        meshes, others, data = {}, [], parts.read_bytes()
        while data:
            size = int.from_bytes(data[:4], "little")
            part, data = _proto.BackupPart.FromString(data[4:4 + size]), data[4 + size:]
            if part.WhichOneof("content") == "mesh":
                meshes[part.mesh.digest] = meshes.get(part.mesh.digest, b"") + part.mesh.data
                part.mesh.data = b""
                if part.mesh.more:
                    continue
            others.append(part.SerializeToString())
        (self.folder / "copy/meshes").mkdir()
        for digest, content in meshes.items():
            (self.folder / "copy/meshes" / digest[7:71]).write_bytes(content)
        parts.write_bytes(b"".join(len(part).to_bytes(4, "little") + part for part in others))
        names = ["scenes.parts", *(f"meshes/{digest[7:71]}" for digest in meshes)]
        sums.write_text(subprocess.run(["sha256sum", *names], cwd=parts.parent, text=True, capture_output=True,
                                       check=True).stdout)
        self.node.delete()
        with sightline.serve(data_dir=self.folder / "other") as other:
            self.assertEqual(len(other.client.restore(self.folder / "copy")), 2)
            self.assertEqual(other.client.scene("box").find("second").id, self.node.id)
        mesh = self.folder / "copy" / names[1]
        mesh.write_bytes(mesh.read_bytes()[:-1] + b"\7")
        with self.assertRaisesRegex(sightline.DataLoss, "BACKUP_CORRUPT"):
            self.client.restore(self.folder / "copy")
        whole = sums.read_text()
        for bad in ("", whole[10:], whole + f"{'0' * 64}  ../data/log\n", whole + "x\n"):
            sums.write_text(bad)
            with self.assertRaisesRegex(sightline.DataLoss, "BACKUP_CORRUPT"):
                self.client.restore(self.folder / "copy")

    @unittest.skipUnless(COMMAND.exists(), "needs the command")
    def test_the_command_reads_and_writes_the_same(self):
        def run(*words):
            subprocess.run([COMMAND, "--endpoint", self.server.endpoint, *words], check=True, capture_output=True)

        self.client.backup(self.folder / "ours")
        run("backup", self.folder / "its")
        self.node.delete()
        run("restore", self.folder / "ours")
        self.assertEqual(self.seen(), [True, True, False])
        self.node = self.client.scene("box").delete_node(self.node.id)
        self.assertEqual(len(self.client.restore(self.folder / "its")), 2)
        self.assertEqual(self.seen(), [True, True, False])


if __name__ == "__main__":
    unittest.main()
