"""Limits of a server that keeps scenes on disk."""

from __future__ import annotations

import dataclasses
from typing import Any


@dataclasses.dataclass(frozen=True)
class StorageLimits:
    """Limits of a server that keeps scenes on disk."""

    max_log_revisions: int  #: revisions of one scene that are not yet part of its written nodes
    max_log_bytes: int
    max_disk_bytes: int  #: everything in the data directory
    min_free_disk_bytes: int  #: what stays free in the file system; below it, writes are refused
    max_batches_in_flight: int  #: not yet committed, on the whole server
    max_batch_bytes_in_flight: int
    mesh_grace_ms: int  #: how long a mesh that nothing names is kept
    max_backup_calls: int  #: Backup and Restore together

    @classmethod
    def of(cls, limits: Any) -> "StorageLimits":
        """The value of a message StorageLimits."""
        return cls(**{field.name: getattr(limits, field.name) for field in dataclasses.fields(cls)})
