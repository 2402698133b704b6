"""Backups of a server's scenes in a directory: the files that the command `sightline backup` writes.

`scenes.parts` has the parts as the server sends them, each after its length in 4 bytes, least significant first;
SHA256SUMS its sum, as sha256sum writes it. A directory is a backup only once `scenes.parts` has its name.
"""

from __future__ import annotations

import hashlib
import os
import pathlib
from typing import Any, BinaryIO, Callable, Iterator, List, Optional, Tuple

from google.protobuf.message import DecodeError

from . import _proto, errors
from ._connection import Connection
from ._progress import reporter
from ._types import Path, Progress
from .backup_scene import BackupScene
from .restored_scene import RestoredScene

_PARTS, _INCOMPLETE, _SUMS = "scenes.parts", "incomplete", "SHA256SUMS"
_LARGEST_PART = 64 << 20
_BLOCK = 1 << 20


def backup(connection: Connection, directory: Path, scene: str, timeout: Optional[float],
           progress: Progress) -> "List[BackupScene]":
    """See Client.backup."""
    folder = pathlib.Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise errors.FailedPrecondition(f"{folder} is not empty: name a new directory", "BACKUP_NOT_EMPTY")
    incomplete = folder / _INCOMPLETE
    try:
        with incomplete.open("xb") as file, reporter(progress, None, "B") as report:
            scenes, total = _receive(connection, file, scene, timeout, report)
    except BaseException:
        incomplete.unlink()  # the directory may be named again
        raise
    with (folder / _SUMS).open("x") as sums:
        sums.write(_sums_line(total))
        sums.flush()
        os.fsync(sums.fileno())
    incomplete.rename(folder / _PARTS)
    _sync(folder)
    return scenes


def _receive(connection: Connection, file: BinaryIO, scene: str, timeout: Optional[float],
             report: "Callable[[int], None]") -> "Tuple[List[BackupScene], str]":
    """Writes the parts. Returns the scenes and the sum of the bytes."""
    begun: "Optional[BackupScene]" = None
    scenes: "List[BackupScene]" = []
    sha = hashlib.sha256()
    with connection.stream("Backup", _proto.BackupRequest(scene=scene), timeout, scene) as stream:
        for message in stream:
            part = message.part
            kind = part.WhichOneof("content")
            if kind == "scene":
                begun = BackupScene(part.scene.scene.name, part.scene.base, part.scene.revision)
            elif kind == "end" and begun is not None:
                scenes.append(begun)
            data = part.SerializeToString()
            data = len(data).to_bytes(4, "little") + data
            sha.update(data)
            file.write(data)
            report(len(data))
    file.flush()
    os.fsync(file.fileno())
    return scenes, sha.hexdigest()


def _sums_line(total: str) -> str:
    return f"{total}  {_PARTS}\n"


def restore(connection: Connection, directory: Path, scene: str, revision: Optional[int], timeout: Optional[float],
            progress: Progress) -> "List[RestoredScene]":
    """See Client.restore."""
    path = pathlib.Path(directory) / _PARTS
    with path.open("rb") as file:
        _check_sum(file, path)
        first = _proto.RestoreRequest(scene=scene, revision=revision or 0)
        with reporter(progress, path.stat().st_size, "B") as report:
            failed: "List[Exception]" = []
            try:
                answer = connection.call("Restore", _requests(file, path, first, report, failed), timeout, light=False)
            except errors.SightlineError as error:
                raise failed[0] if failed else error  # gRPC's thread reads the file, and its error ends the call
    return [RestoredScene(one.name, one.revision.revision, one.revision.token) for one in answer.scenes]


def _requests(file: BinaryIO, path: pathlib.Path, first: Any, report: Any,
              failed: "List[Exception]") -> "Iterator[Any]":
    request = first
    try:
        for size, part in _parts(file, path):
            request.part.CopyFrom(part)
            yield request
            report(size)
            request = _proto.RestoreRequest()
    except Exception as error:
        failed.append(error)
        raise


def _parts(file: BinaryIO, path: pathlib.Path) -> "Iterator[Any]":
    while True:
        head = file.read(4)
        if not head:
            return
        size = int.from_bytes(head, "little")
        data = file.read(size) if len(head) == 4 and size <= _LARGEST_PART else b""
        if len(data) != size or len(head) != 4:
            raise _not_whole(path)
        try:
            yield size + 4, _proto.BackupPart.FromString(data)
        except DecodeError:
            raise _not_whole(path) from None


def _check_sum(file: BinaryIO, path: pathlib.Path) -> None:
    sha = hashlib.sha256()
    for block in iter(lambda: file.read(_BLOCK), b""):
        sha.update(block)
    file.seek(0)
    with (path.parent / _SUMS).open() as sums:
        if sums.readline() != _sums_line(sha.hexdigest()):
            raise _not_whole(path)


def _not_whole(path: pathlib.Path) -> errors.DataLoss:
    return errors.DataLoss(f"{path} is not what was written: restore another backup", "BACKUP_CORRUPT")


def _sync(folder: pathlib.Path) -> None:
    number = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(number)
    finally:
        os.close(number)
