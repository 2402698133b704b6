"""Backups of a server's scenes in a directory: the files that the command `sightline backup` writes.

`scenes.parts` has the parts as the server sends them, each after its length in 4 bytes, least significant first;
SHA256SUMS its sum, as sha256sum writes it. A directory is a backup only once `scenes.parts` has its name.
"""

from __future__ import annotations

import hashlib
import os
import pathlib
from typing import Any, BinaryIO, Callable, Iterator, List, Optional, Tuple

from . import _proto, errors
from ._backup_reader import PARTS, SUMS, BackupReader
from ._connection import Connection
from ._progress import reporter
from ._types import Path, Progress
from .backup_scene import BackupScene
from .restored_scene import RestoredScene

_INCOMPLETE = "incomplete"  # the name of the parts while they come


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
    with (folder / SUMS).open("x") as sums:
        sums.write(f"{total}  {PARTS}\n")
        sums.flush()
        os.fsync(sums.fileno())
    incomplete.rename(folder / PARTS)
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


def restore(connection: Connection, directory: Path, scene: str, revision: Optional[int], timeout: Optional[float],
            progress: Progress) -> "List[RestoredScene]":
    """See Client.restore."""
    first = _proto.RestoreRequest(scene=scene, revision=revision or 0)
    failed: "List[Exception]" = []
    with BackupReader(pathlib.Path(directory)) as reader, reporter(progress, reader.size, "B") as report:
        try:
            answer = connection.call("Restore", _requests(reader, first, report, failed), timeout, light=False)
        except errors.SightlineError as error:
            raise failed[0] if failed else error  # gRPC's thread reads the file, and its error ends the call
    return [RestoredScene(one.name, one.revision.revision, one.revision.token) for one in answer.scenes]


def _requests(reader: BackupReader, first: Any, report: Any, failed: "List[Exception]") -> "Iterator[Any]":
    request = first
    try:
        for size, part in reader.parts():
            request.part.CopyFrom(part)
            yield request
            report(size)
            request = _proto.RestoreRequest()
    except Exception as error:
        failed.append(error)
        raise


def _sync(folder: pathlib.Path) -> None:
    number = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(number)
    finally:
        os.close(number)
