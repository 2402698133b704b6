"""A local client that means no good: it goes as far as it is told with a segment, and then waits to be killed.

hostile_client.py ENDPOINT SCENE STEP

When it is there it prints a line: the segment's name, the pages that its file has, and whether these have any byte that is not
zero; "-" where it has no file. It prints another one for each line that it reads.
"""

import array
import ctypes
import errno
import mmap
import os
import socket
import sys
import threading

import sightline
from sightline import _proto
from sightline._query import COLUMNS

STEPS = ("opened", "connected", "half a key", "key", "key with itself", "taken", "mapped", "cut", "casting", "ended", "left",
         "left first")
BYTES = 4 << 20
_RAYS = 20_000


def forbidden(act):
    """Fails unless the system refuses it."""
    try:
        act()
    except OSError as error:
        assert error.errno == errno.EPERM, error
    else:
        raise AssertionError("the system allows it")


class HostileClient:
    def __init__(self, endpoint, scene, step):
        self._scene, self._step = scene, step
        self._client = sightline.connect(endpoint, use_segments=False)
        self._file = None

    def _goes_to(self, step):
        return STEPS.index(self._step) >= STEPS.index(step)

    def run(self):
        call = self._client._connection.begin("OpenSegment", _proto.OpenSegmentRequest(bytes=BYTES))
        self._call = call
        self._opened = next(call)
        if self._goes_to("connected"):
            self._connection = socket.socket(socket.AF_UNIX)
            self._connection.connect(b"\0" + self._opened.socket)
        if self._goes_to("half a key"):
            self._connection.sendall(self._opened.key[:16])
        if self._step == "key with itself":  # what waits to be read there keeps its own connection open
            socket.send_fds(self._connection, [self._opened.key[16:] + b"more"], [self._connection.fileno()])
        elif self._goes_to("key"):
            self._connection.sendall(self._opened.key[16:])
        if self._goes_to("taken"):
            _, (self._file,), _, _ = socket.recv_fds(self._connection, 1, 1)
        if self._goes_to("mapped"):
            self._memory = mmap.mmap(self._file, BYTES)
            self._memory[:] = b"\xff" * BYTES
        if self._step == "cut":
            self._cut()
        if self._step == "casting":
            self._cast()
        if self._step in ("ended", "left"):
            call.cancel()
        if self._step in ("left", "left first"):
            self._connection.close()
        if self._step == "left first":
            call.cancel()

    def _cut(self):
        import fcntl

        forbidden(lambda: os.ftruncate(self._file, 0))
        forbidden(lambda: os.ftruncate(self._file, 2 * BYTES))
        forbidden(lambda: fcntl.fcntl(self._file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_WRITE))
        libc = ctypes.CDLL(None)
        # A mapping of more than there is ends who writes there, and no other.
        libc.mmap.restype = ctypes.c_void_p
        beyond = libc.mmap(None, ctypes.c_size_t(2 * BYTES), mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_SHARED, self._file,
                           ctypes.c_long(0))
        child = os.fork()
        if child == 0:
            ctypes.memset(beyond + BYTES, 1, 1)
            os._exit(0)
        assert os.WIFSIGNALED(os.waitpid(child, 0)[1])
        keep_size_and_punch_hole = 3
        assert libc.fallocate(self._file, keep_size_and_punch_hole, ctypes.c_long(0), ctypes.c_long(BYTES)) == 0

    def _cast(self):
        """Casts again and again, while rays change and answers are written over."""
        request = _proto.CastRaysRequest(scene=self._scene, segment=self._opened.segment)
        request.shared.count, request.shared.origins, request.shared.directions = _RAYS, 0, 12 * _RAYS
        request.answer.add(field=COLUMNS["t"].number, offset=24 * _RAYS)
        sent = request.SerializeToString()
        noise = array.array("f", [0.0, 1.0, -1.0, float("inf"), float("nan"), 1e30]).tobytes()
        noises = [(noise[4 * i:] + noise * (BYTES // len(noise) + 1))[:BYTES] for i in range(3)]

        def change():
            while True:
                for one in noises:
                    self._memory[:] = one

        def cast():
            while True:
                self._client._connection.call("CastRays", sent)

        threading.Thread(target=change, daemon=True).start()
        for _ in range(5):
            self._client._connection.call("CastRays", sent)
        threading.Thread(target=cast, daemon=True).start()

    def line(self):
        pages, bytes_left = "-", "-"
        if self._file is not None:
            pages = os.fstat(self._file).st_blocks * 512 // mmap.PAGESIZE
            bytes_left = any(os.pread(self._file, BYTES, 0))
        return f"{self._opened.segment} {pages} {bytes_left}"


if __name__ == "__main__":
    client = HostileClient(*sys.argv[1:])
    client.run()
    print(client.line(), flush=True)
    for _ in sys.stdin:
        print(client.line(), flush=True)
