#!/usr/bin/env python3
"""Floods of frames from peers that have shown no token, with and without TLS: the server ends their connections, tells why, keeps
little, and serves others meanwhile.

floods_test.py SIGHTLINED [FLOOD...]
"""

import contextlib
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.request

from frames import (ACK, DATA, EMPTY_MESSAGE, END_HEADERS, END_STREAM, ENHANCE_YOUR_CALM, FLOODS, GREETING, HEADERS, INFO,
                    PATIENCE, RST_STREAM, SETTINGS, Peer, frame)

BUDGET = 256 << 20
MOST_KEPT = 96 << 20  # bytes beyond what the server has at its start
SIGHTLINED, CHOSEN = sys.argv[1], sys.argv[2:]

#: gRPC itself ends these connections at the first frame, without a word.
ERRORS = {"made_reset", "padded_data", "old_headers", "empty_headers_same", "hpack_bomb"}
TRIES = 3  # a GOAWAY can be lost: the system resets a connection that is closed with bytes unread


class Server:
    def __init__(self, folder, tls):
        # Nobody has this token.
        (folder / "tokens.toml").write_text(f'[[token]]\nname = "a"\nsha256 = "{"0" * 64}"\nrole = "admin"\nscenes = [""]\n')
        flags = ["--tokens", folder / "tokens.toml", "--memory-budget", str(BUDGET), "--threads", "1"]
        if tls:
            flags += ["--tls-cert", folder / "server.pem", "--tls-key", folder / "server.key"]
        self.tls = tls
        self.log = (folder / "log").open("w+")
        self.process = subprocess.Popen([SIGHTLINED, "--listen", "127.0.0.1:0", "--admin", "127.0.0.1:0", *flags], stderr=self.log)
        started = self.wait_for_log(r"event=started .* port=(\d+) admin_port=(\d+)")
        self.port, self.admin = int(started[1]), int(started[2])

    def wait_for_log(self, pattern):
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            found = re.search(pattern, pathlib.Path(self.log.name).read_text())
            if found:
                return found
            time.sleep(0.02)
        sys.exit(f"failed: no {pattern} in the log")

    def resident(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) << 10

    def ended(self):
        """Connections that were ended so far."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.admin}/metrics", timeout=PATIENCE) as reply:
            text = reply.read().decode()
        return sum(float(value) for value in re.findall(r'^sightline_connections_ended_total\{.*\} (\S+)$', text, re.MULTILINE))

    def answers(self):
        """Whether a call of another client is answered, though without a token it is refused."""
        peer = Peer(self.port, self.tls)
        peer.send(GREETING + call(1))
        answered = peer.wait(lambda: peer.answered)
        peer.close()
        return bool(answered)

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.log.close()


def call(stream):
    return frame(HEADERS, END_HEADERS, stream, INFO) + frame(DATA, END_STREAM, stream, EMPTY_MESSAGE)


def flood(server, name):
    """What is wrong, or nothing."""
    for _ in range(TRIES):
        code, wrong = flood_once(server, name)
        if wrong or name in ERRORS or code == ENHANCE_YOUR_CALM:
            return wrong
    return f"{name}: GOAWAY has the code {code}"


def flood_once(server, name):
    """The code of the GOAWAY frame, and what else is wrong, or nothing."""
    before, ended_before = server.resident(), server.ended()
    peer = Peer(server.port, server.tls)
    until, most = time.monotonic() + PATIENCE, before
    taken = peer.send(GREETING)
    for number, piece in enumerate(FLOODS[name]()):
        taken = peer.send(piece)
        if number % 16 == 0:
            most = max(most, server.resident())
        if not taken or time.monotonic() > until or most - before > 10 * MOST_KEPT:
            break
    if not taken:
        peer.wait(lambda: peer.ended)
    most = max(most, server.resident())
    code, ended = peer.goaway, server.ended() - ended_before
    peer.close()
    kept = most - before
    print(f"  {name}: {peer.sent / 1e6:.1f} MB sent, {kept / 1e6:.0f} MB kept, GOAWAY {code}, ended {ended:.0f}", flush=True)
    wrong = None
    if server.process.poll() is not None:
        sys.exit(f"failed: {name}: the server has ended")
    elif not peer.ended:
        wrong = f"{name}: the connection did not end"
    elif kept > MOST_KEPT:
        wrong = f"{name}: {kept} bytes are kept"
    elif not server.answers():
        wrong = f"{name}: another client has no answer"
    return code, wrong


def hedge(server):
    """A client that sends each call twice and gives one of them up is served. What is wrong, or nothing."""
    peer = Peer(server.port, server.tls)
    peer.send(GREETING)
    for number in range(300):  # more than may be given up at once
        stream = 4 * number + 1
        taken = peer.send(call(stream) + frame(HEADERS, END_HEADERS, stream + 2, INFO) +
                          frame(RST_STREAM, 0, stream + 2, (8).to_bytes(4, "big")))
        if not taken or not peer.wait(lambda: stream in peer.answered):
            return f"hedged calls: ended at number {number}, GOAWAY {peer.goaway}"
        if number == 0:
            peer.send(frame(SETTINGS, ACK))
    peer.close()
    return None


def check(tls):
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as at_end:
        folder = pathlib.Path(name)
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-subj", "/CN=localhost", "-days", "2", "-keyout",
                        folder / "server.key", "-out", folder / "server.pem"], check=True, capture_output=True)
        server = Server(folder, tls)
        at_end.callback(server.stop)
        print("with TLS" if tls else "without TLS", flush=True)
        wrong = [flood(server, name) for name in CHOSEN or FLOODS]
        if not CHOSEN:
            wrong.append(hedge(server))
        server.wait_for_log("event=connection_ended reason=")
        return [text for text in wrong if text]


def main():
    wrong = check(tls=False) + check(tls=True)
    if wrong:
        sys.exit("failed:\n" + "\n".join(wrong))


if __name__ == "__main__":
    main()
