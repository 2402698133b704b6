"""A segment: memory that this process and the server map, and the call that keeps it."""

from __future__ import annotations

import array
import errno
import mmap
import os
import select
import socket
import struct
import threading
import weakref
from collections import deque
from queue import Empty, SimpleQueue
from typing import Any, Deque, List, Optional, Tuple

import grpc
import numpy as np

from . import errors
from ._scope import scope

ALIGNMENT = 64  # bytes, of blocks
_KEY_BYTES = 32
_LONGEST_NAME = 107  # of an abstract socket


def aligned(size: int) -> int:
    """Rounded up to a multiple of ALIGNMENT."""
    return -(-size // ALIGNMENT) * ALIGNMENT


class BlockList:
    """Free parts of `size` bytes: the lowest that is large enough is taken. Threads: one at a time."""

    def __init__(self, size: int):
        self._free: "List[Tuple[int, int]]" = [(0, size // ALIGNMENT * ALIGNMENT)] if size >= ALIGNMENT else []

    def take(self, size: int) -> Optional[int]:
        """Where a block of this size begins; None: there is no room."""
        needed = aligned(max(size, 1))
        for i, (offset, free) in enumerate(self._free):
            if free >= needed:
                self._free[i:i + 1] = [(offset + needed, free - needed)] if free > needed else []
                return offset
        return None

    def release(self, offset: int, size: int) -> None:
        """Frees a block that was taken with this size."""
        merged: "List[Tuple[int, int]]" = []
        for begin, length in sorted([*self._free, (offset, aligned(max(size, 1)))]):
            if merged and sum(merged[-1]) == begin:
                merged[-1] = (merged[-1][0], merged[-1][1] + length)
            else:
                merged.append((begin, length))
        self._free = merged


class Segment:
    """Threads: any. `name` is what requests call it. Without a call it is memory of this process alone, with the reason
    why."""

    def __init__(self, memory: mmap.mmap, call: Any = None, name: str = "", reason: str = "", process: Optional[int] = None):
        self.name = name
        self._process = process  # a descriptor of the server's
        self.bytes = np.frombuffer(memory, np.uint8)
        self.address = self.bytes.ctypes.data
        self._reason = reason
        self._state = "shared" if call is not None else "unshared"
        self._lock = threading.Lock()
        self._blocks = BlockList(len(self.bytes))
        # Blocks of arrays come back while garbage is collected, which can happen while the lock is held.
        self._released: "Deque[Tuple[int, int]]" = deque()
        if call is not None:
            weakref.finalize(self, call.cancel).atexit = False
        if process is not None:
            weakref.finalize(self, os.close, process).atexit = False

    @property
    def size(self) -> int:
        return len(self.bytes)

    @property
    def is_shared(self) -> bool:
        """Whether requests may name it."""
        return self._state == "shared"

    @property
    def is_abandoned(self) -> bool:
        """Whether the server may still write to it for a call that is over here."""
        return self._state == "abandoned"

    @property
    def why_not_shared(self) -> str:
        """Empty: it is."""
        return {"shared": "", "unshared": self._reason,
                "lost": "the server that had it is gone, or has taken it back",
                "abandoned": "a cast that used it failed, and the server may still write to it"}[self._state]

    def has_server_ended(self, seconds: float) -> bool:
        """Whether the server's process has certainly ended, now or within so many seconds."""
        if self._process is None:
            return False
        end = select.poll()
        end.register(self._process, select.POLLIN)
        return bool(end.poll(1000 * seconds))

    def lose(self) -> None:
        """The server does not know it any more."""
        if self._state == "shared":
            self._state = "lost"

    def abandon(self) -> None:
        """A call that named it ended here, and perhaps not at the server: nothing of it is used again."""
        if self._state != "unshared":
            self._state = "abandoned"

    def take(self, size: int) -> Optional[int]:
        """The offset of a block; None: there is no room."""
        with self._lock:
            while self._released:
                self._blocks.release(*self._released.popleft())
            return None if self.is_abandoned else self._blocks.take(size)

    def release(self, offset: int, size: int) -> None:
        """Frees a block that was taken with this size."""
        self._released.append((offset, size))

    def array(self, offset: int, dtype: np.dtype, count: int) -> np.ndarray:
        """A view of `count` values."""
        return self.bytes[offset:offset + count * dtype.itemsize].view(dtype)

    def offset_of(self, column: np.ndarray) -> Optional[int]:
        """Where an array lies in it; None: not in it, or not as one piece."""
        if column.dtype.hasobject or not column.flags.c_contiguous:
            return None
        offset = column.ctypes.data - self.address
        return offset if 0 <= offset and offset + column.nbytes <= self.size else None


def unshared(size: int, reason: str) -> Segment:
    """Errors: ResourceExhausted, there is not as much memory."""
    try:
        return Segment(mmap.mmap(-1, size), reason=reason)
    except (OSError, ValueError, OverflowError) as error:
        raise errors.ResourceExhausted(f"{size} bytes of memory cannot be mapped: {error}") from None


def open_segment(call: Any, size: int, seconds: float) -> Segment:
    """The segment of an OpenSegment call that has begun, which it keeps. Errors: those of the call; DeadlineExceeded,
    nothing came within so many seconds; Unavailable, the memory cannot be had."""
    try:
        opened = _first(call, seconds)
        if not opened.segment or opened.bytes < size:
            raise errors.Internal(f"the server has opened a segment {opened.segment!r} of {opened.bytes} bytes instead "
                                  f"of {size}")
        memory, process = _receive(opened.socket, opened.key, opened.bytes, seconds)
        return Segment(memory, call, opened.segment, process=process)
    except BaseException:
        call.cancel()
        raise


def _first(call: Any, seconds: float) -> Any:
    """The first answer of a call. See _waiting.py for why this thread does not wait for gRPC itself."""
    got: "SimpleQueue[Any]" = SimpleQueue()

    def take() -> None:
        try:
            got.put((next(call), None))
        except BaseException as error:  # it is raised in the thread that waits
            got.put((None, error))

    current = scope.get()
    if current is not None:
        current.add(call)
    threading.Thread(target=take, name="sightline-segment", daemon=True).start()
    try:
        opened, error = got.get(timeout=seconds)
    except Empty:
        raise errors.DeadlineExceeded("the server has not answered the request for a segment") from None
    finally:
        if current is not None:
            current.remove(call)
    if isinstance(error, grpc.RpcError):
        raise errors.of_call(error) from None
    if error is not None:
        raise errors.Internal("the server has ended the call of a segment without one") from None
    return opened


def _receive(name: bytes, key: bytes, size: int, seconds: float) -> "Tuple[mmap.mmap, Optional[int]]":
    """Connects to the socket of this abstract name, sends the key, and maps what is sent back. The connection stays open
    until the last array in the memory is gone: then the server may take its pages back. Beside it a descriptor of the
    process there; None: it is not known."""
    if not 0 < len(name) <= _LONGEST_NAME or len(key) != _KEY_BYTES:
        raise errors.Internal(f"the server's name of a socket has {len(name)} bytes instead of up to {_LONGEST_NAME}, or "
                              f"its key {len(key)} instead of {_KEY_BYTES}")
    descriptors = array.array("i")
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
            connection.settimeout(seconds)
            connection.connect(b"\0" + name)
            connection.sendall(key)
            _, control, _, _ = connection.recvmsg(1, socket.CMSG_SPACE(4 * descriptors.itemsize),
                                                  socket.MSG_CMSG_CLOEXEC)
            for level, kind, data in control:
                if level == socket.SOL_SOCKET and kind == socket.SCM_RIGHTS:
                    descriptors.frombytes(data[:len(data) // descriptors.itemsize * descriptors.itemsize])
            peer = struct.unpack("3i", connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))[0]
            if len(descriptors) != 1:
                raise errors.Unavailable(f"the server has sent {len(descriptors)} descriptors instead of that of the "
                                         "segment")
            memory = _map(descriptors[0], size)
            weakref.finalize(memory, os.close, connection.detach()).atexit = False
        return memory, _descriptor_of(peer)
    except OSError as error:
        if isinstance(error, errors.SightlineError):
            raise
        raise errors.Unavailable(f"the server's segment cannot be had: {error}") from None
    finally:
        for descriptor in descriptors:
            os.close(descriptor)


def _descriptor_of(process: int) -> Optional[int]:
    try:
        return os.pidfd_open(process) if process > 0 else None
    except (AttributeError, OSError):  # not of this system
        return None


def _map(descriptor: int, size: int) -> mmap.mmap:
    import fcntl  # which other systems do not have; they have no segments either

    if os.fstat(descriptor).st_size < size:
        raise OSError(errno.EINVAL, f"it has fewer than {size} bytes")
    if not fcntl.fcntl(descriptor, fcntl.F_GET_SEALS) & fcntl.F_SEAL_SHRINK:
        raise OSError(errno.EINVAL, "it is not sealed against shrinking")
    return mmap.mmap(descriptor, size, mmap.MAP_SHARED, mmap.PROT_READ | mmap.PROT_WRITE)
