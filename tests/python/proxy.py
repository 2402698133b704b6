"""A proxy between a client and a server on Unix sockets, whose connections can be cut."""

import os
import socket
import tempfile
import threading


class Proxy:
    def __init__(self, endpoint):
        self._target = endpoint.partition(":")[2]
        self._folder = tempfile.TemporaryDirectory()
        path = os.path.join(self._folder.name, "socket")
        self.endpoint = f"unix:{path}"
        self.is_open = True
        self.bytes = 0  # that have gone through, in both directions
        self._cut_after = None
        self._sockets = []
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(path)
        self._listener.listen()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            if not self.is_open:
                near.close()
                continue
            far = socket.socket(socket.AF_UNIX)
            far.connect(self._target)
            self._sockets += [near, far]
            for pair in ((near, far), (far, near)):
                threading.Thread(target=self._copy, args=pair, daemon=True).start()

    def _copy(self, source, sink):
        try:
            while data := source.recv(65536):
                sink.sendall(data)
                self.bytes += len(data)
                if self._cut_after is not None and self.bytes >= self._cut_after:
                    self._cut_after = None
                    self.cut()
        except OSError:
            pass

    def cut_after(self, count):
        """Cuts once, after so many more bytes."""
        self._cut_after = self.bytes + count

    def cut(self):
        """Ends all connections; new ones are accepted."""
        cut, self._sockets = self._sockets, []
        for end in cut:
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def close(self):
        self._listener.close()
        self.cut()
        self._folder.cleanup()
