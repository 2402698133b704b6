"""The files of a backup.

`scenes.parts` has the parts as the server sent them, each after its length in 4 bytes, least significant first. A part
may name a mesh without its bytes: `meshes` has a file of them, by their SHA-256 in hex. SHA256SUMS has the sums of all
files, as sha256sum writes them, of `scenes.parts` first. A directory is a backup only once `scenes.parts` has its name.
"""

from __future__ import annotations

import hashlib
import pathlib
import re
from typing import Any, BinaryIO, Iterator, Tuple

from google.protobuf.message import DecodeError

from . import _proto, errors

PARTS, SUMS = "scenes.parts", "SHA256SUMS"
_LARGEST_PART = 64 << 20
_BLOCK = 1 << 20
_PIECE = 512 << 10  # bytes of a mesh in a part
_DIGEST = re.compile(r"sha256:([0-9a-f]{64})/([1-9][0-9]*)")
_SUM_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


class BackupReader:
    """For `with`. Reads all files once, to compare their sums. Errors: OSError; DataLoss, one is not what was written."""

    def __init__(self, folder: pathlib.Path):
        self._folder, self._path = folder, folder / PARTS
        self._file: BinaryIO = self._path.open("rb")
        try:
            self.size = self._path.stat().st_size  #: of the parts
            self._check_sums()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> "BackupReader":
        return self

    def __exit__(self, *_: Any) -> None:
        self._file.close()

    def parts(self) -> "Iterator[Tuple[int, Any]]":
        """The parts for the server, each with the bytes of `scenes.parts` that are read for it."""
        while True:
            head = self._file.read(4)
            if not head:
                return
            size = int.from_bytes(head, "little")
            data = self._file.read(size) if len(head) == 4 and size <= _LARGEST_PART else b""
            if len(head) != 4 or len(data) != size:
                raise _not_whole(self._path)
            try:
                part = _proto.BackupPart.FromString(data)
            except DecodeError:
                raise _not_whole(self._path) from None
            if part.WhichOneof("content") == "mesh" and not part.mesh.data:
                yield from self._mesh_parts(part.mesh.digest)
            else:
                yield size + 4, part

    def _mesh_parts(self, digest: str) -> "Iterator[Tuple[int, Any]]":
        found = _DIGEST.fullmatch(digest)  # the sum becomes the name of a file
        if found is None:
            raise _not_whole(self._path)
        path, rest = self._folder / "meshes" / found[1], int(found[2])
        with path.open("rb") as file:
            while rest:
                data = file.read(min(rest, _PIECE))
                if not data:
                    raise _not_whole(path)
                rest -= len(data)
                yield 0, _proto.BackupPart(mesh=_proto.BackupMesh(digest=digest, data=data, more=rest > 0))

    def _check_sums(self) -> None:
        lines = [_SUM_LINE.fullmatch(line) for line in (self._folder / SUMS).read_text().splitlines()]
        names = [line[2] if line else "" for line in lines]
        if names[:1] != [PARTS]:
            raise _not_whole(self._path)
        for line, name in zip(lines, names):
            if line is None or name not in (PARTS, f"meshes/{line[1]}"):
                raise _not_whole(self._folder / SUMS)
            with (self._folder / name).open("rb") as file:
                if _sum_of(file) != line[1]:
                    raise _not_whole(self._folder / name)


def _sum_of(file: BinaryIO) -> str:
    sha = hashlib.sha256()
    for block in iter(lambda: file.read(_BLOCK), b""):
        sha.update(block)
    return sha.hexdigest()


def _not_whole(path: pathlib.Path) -> errors.DataLoss:
    return errors.DataLoss(f"{path} is not what was written: restore another backup", "BACKUP_CORRUPT")
