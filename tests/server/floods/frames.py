"""HTTP/2 as a peer may send it: frames, and floods of them."""

import select
import socket
import ssl
import struct
import time

DATA, HEADERS, PRIORITY, RST_STREAM, SETTINGS, PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = 0, 1, 2, 3, 4, 6, 7, 8, 9
END_STREAM, ACK, END_HEADERS = 1, 1, 4
CANCEL, ENHANCE_YOUR_CALM = 8, 11
PATIENCE = 60  # seconds: only a test that fails takes them
NOT_NOW = (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError)
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"


def frame(kind, flags=0, stream=0, payload=b""):
    return struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", stream) + payload


def literal(name, value):
    """A field that no table keeps, of less than 127 bytes each."""
    return b"\0" + bytes([len(name)]) + name + bytes([len(value)]) + value


def request(path, *more):
    fields = [(b":method", b"POST"), (b":scheme", b"http"), (b":path", path), (b":authority", b"x"), (b"te", b"trailers"),
              (b"content-type", b"application/grpc"), *more]
    return b"".join(literal(name, value) for name, value in fields)


GREETING = PREFACE + frame(SETTINGS)
INFO = request(b"/sightline.v1.ServerService/GetServerInfo")
EMPTY_MESSAGE = bytes(5)


def repeated(part):
    def pieces():
        while True:
            yield part * (16384 // len(part) + 1)
    return pieces


def by_stream(part, first=1):
    """part(stream) for each stream that a client may open."""
    def pieces():
        stream = first
        while stream < 2**31 - 200:
            yield b"".join(part(stream + 2 * i) for i in range(100))
            stream += 200
    return pieces


def after(start, pieces):
    def both():
        yield start
        yield from pieces()
    return both


OPEN = frame(HEADERS, END_HEADERS, 1, INFO)
HUGE = b"\0\1x\x7f\xd5\x79" + b"v" * 15700  # a field with a value of 16 KB
# A field of 4 KB that the table keeps, and a block of references to it.
KEPT, KNOWN = b"\x40\1x\x7f\xc1\x1e" + b"v" * 4032, b"\xbe" * 12000

#: What a peer may send without end: a name, and what it is made of.
FLOODS = {
    "rapid_reset": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO) + frame(RST_STREAM, 0, s, struct.pack(">I", CANCEL))),
    "made_reset": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO) + frame(WINDOW_UPDATE, 0, s, bytes(4))),
    "made_reset_data": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO) + frame(DATA, 0xff, s, b"\1")),
    "streams": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO)),
    "streams_acknowledged": after(frame(SETTINGS, ACK), by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO))),
    "continuation": after(frame(HEADERS, 0, 1, INFO), repeated(frame(CONTINUATION, 0, 1, literal(b"a", b"b" * 100)))),
    "continuation_empty": after(frame(HEADERS, 0, 1, INFO), repeated(frame(CONTINUATION, 0, 1))),
    "continuation_string": after(frame(HEADERS, 0, 1, INFO + b"\0\1x\x7f\x81\xff\xff\x7f"), repeated(frame(CONTINUATION, 0, 1, b"v" * 1000))),
    "continuation_ended": by_stream(lambda s: frame(HEADERS, 0, s, INFO) + frame(CONTINUATION, END_HEADERS, s, literal(b"a", b"b"))),
    "huge_headers": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO + HUGE)),
    "hpack_bomb": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO + KEPT + KNOWN)),
    "hpack_references": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO + b"\x40\1x\0" + b"\xbe" * 15000)),
    "old_headers": after(OPEN, repeated(frame(HEADERS, END_HEADERS, 1, INFO))),
    "even_headers": repeated(frame(HEADERS, END_HEADERS, 2, INFO)),
    "empty_headers": by_stream(lambda s: frame(HEADERS, END_HEADERS, s)),
    "empty_headers_same": after(OPEN, repeated(frame(HEADERS, END_HEADERS, 1))),
    "trailers": by_stream(lambda s: frame(HEADERS, END_HEADERS, s, INFO) + frame(HEADERS, END_HEADERS | END_STREAM, s)),
    "empty_data": after(OPEN, repeated(frame(DATA, 0, 1))),
    "empty_data_idle": repeated(frame(DATA, 0, 1)),
    "padded_data": after(OPEN, repeated(frame(DATA, 8, 1, b"\xff" + bytes(255)))),
    "small_data": after(OPEN, repeated(frame(DATA, 0, 1, b"\0"))),
    "settings": repeated(frame(SETTINGS)),
    "settings_table": repeated(frame(SETTINGS, 0, 0, struct.pack(">HI", 1, 0)) + frame(SETTINGS, 0, 0, struct.pack(">HI", 1, 2**32 - 1))),
    "settings_window": after(OPEN, repeated(frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 0)) + frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 2**31 - 1)))),
    "settings_long": repeated(frame(SETTINGS, 0, 0, struct.pack(">HI", 3, 100) * 2700)),
    "settings_ack": repeated(frame(SETTINGS, ACK)),
    "ping": repeated(frame(PING, 0, 0, bytes(8))),
    "ping_ack": repeated(frame(PING, ACK, 0, bytes(8))),
    "ping_between": by_stream(lambda s: frame(HEADERS, END_HEADERS | END_STREAM, s, INFO) + frame(PING, 0, 0, bytes(8)) * 10),
    "priority": repeated(frame(PRIORITY, 0, 1, bytes(5))),
    "priority_streams": by_stream(lambda s: frame(PRIORITY, 0, s, bytes(5))),
    "window_update": repeated(frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", 1))),
    "window_update_stream": after(OPEN, repeated(frame(WINDOW_UPDATE, 0, 1, struct.pack(">I", 1)))),
    "reset_idle": by_stream(lambda s: frame(RST_STREAM, 0, s, struct.pack(">I", CANCEL))),
    "goaway": repeated(frame(GOAWAY, 0, 0, bytes(8) + b"x" * 100)),
    "unknown": repeated(frame(0x77, 0, 0)),
    "stalled": after(frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 0)), by_stream(
        lambda s: frame(HEADERS, END_HEADERS, s, INFO) + frame(DATA, END_STREAM, s, EMPTY_MESSAGE))),
}


class Peer:
    """A connection that takes what comes whenever it sends or waits. One thread uses it, as a TLS connection allows no more."""

    def __init__(self, port, tls=False):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        if tls:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            context.set_alpn_protocols(["h2"])
            self.socket = context.wrap_socket(self.socket)
        self.socket.setblocking(False)
        self.sent, self.answered, self.goaway = 0, set(), None  # bytes, streams, and the code of a GOAWAY frame
        self.ended = False
        self._rest = b""

    def send(self, piece):
        """False once the other side has ended the connection, or takes nothing any more."""
        left, until = memoryview(piece), time.monotonic() + PATIENCE
        while left and not self.ended and time.monotonic() < until:
            self._take()
            try:
                size = self.socket.send(left)
                left, self.sent = left[size:], self.sent + size
            except NOT_NOW:
                select.select([self.socket], [self.socket], [], 1)
            except OSError:
                self._take()
                self.ended = True
        return not left and not self.ended

    def wait(self, holds, seconds=PATIENCE):
        """Takes what comes until that holds, or the connection has ended. Returns whether it holds."""
        until = time.monotonic() + seconds
        self._take()
        while not holds() and not self.ended and time.monotonic() < until:
            select.select([self.socket], [], [], 0.1)
            self._take()
        return holds()

    def _take(self):
        try:
            while piece := self.socket.recv(65536):
                self._read(piece)
            self.ended = True
        except NOT_NOW:
            pass
        except OSError:
            self.ended = True

    def _read(self, piece):
        self._rest += piece
        while len(self._rest) >= 9:
            size, kind, flags = int.from_bytes(self._rest[:3], "big"), self._rest[3], self._rest[4]
            if len(self._rest) < 9 + size:
                break
            if kind == GOAWAY:
                self.goaway = int.from_bytes(self._rest[13:17], "big")
            if kind == HEADERS and flags & END_STREAM:
                self.answered.add(int.from_bytes(self._rest[5:9], "big"))
            self._rest = self._rest[9 + size:]

    def close(self):
        self.socket.close()
