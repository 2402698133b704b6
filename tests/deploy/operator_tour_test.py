#!/usr/bin/env python3
"""What a new operator does, from certificates to a restored directory; prints a transcript.

operator_tour_test.py SIGHTLINED SIGHTLINE
"""

import contextlib
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import urllib.request

from operator_files import needs
from own_credentials import make_credentials, shell

RAYS = "".join(f"{x / 10},0.3,10,0,0,-1\n" for x in range(-9, 10))
QUAD = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n"


@contextlib.contextmanager
def running(folder, program):
    """A server with TLS and tokens, and what a client needs to call it; ends it by SIGTERM."""
    command = (f"{program} --listen 127.0.0.1:0 --admin 127.0.0.1:0 --data-dir data --tls-cert server.pem "
               "--tls-key server.key --tokens tokens.toml")
    print(f"$ {command} &", flush=True)
    with subprocess.Popen(shlex.split(command), cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        try:
            for line in process.stderr:
                found = re.search(r" port=(\d+) admin_port=(\d+)", line)
                if found:
                    print(line, end="")
                    break
            else:
                sys.exit("failed: the server did not start")
            yield f"--endpoint 127.0.0.1:{found[1]} --tls-ca ca.pem", f"http://127.0.0.1:{found[2]}"
        finally:
            process.send_signal(signal.SIGTERM)
            rest = process.stderr.read()
            print("$ kill %1\n" + rest, end="")
            if process.wait() != 0:
                sys.exit(f"failed: the server ended with {process.returncode}")


def scrape(url):
    """Readiness and some metrics."""
    for page in ("/livez", "/readyz"):
        with urllib.request.urlopen(url + page, timeout=30) as reply:
            print(f"$ curl {url}{page}\n{reply.status} {reply.read().decode().strip()}")
    with urllib.request.urlopen(url + "/metrics", timeout=30) as reply:
        lines = reply.read().decode().splitlines()
    print(f"$ curl {url}/metrics | grep -E '^sightline_(rays_total|commit_seconds|blob_bytes|certificate)'")
    found = [line for line in lines if re.match(r"sightline_(rays_total|commit_seconds|blob_bytes|certificate)", line)]
    print("\n".join(found))
    if not any(line.startswith('sightline_rays_total{kind="closest"} 19') for line in found):
        sys.exit("failed: the rays were not counted")


def tour(folder, sightlined, sightline):
    make_credentials(folder)
    (folder / "quad.obj").write_text(QUAD)
    with running(folder, sightlined) as (flags, admin):
        shell(folder, f"{sightline} {flags} scene ls", fails=True)  # no token
        operator, reader = (f"{flags} --token-file {name}.token" for name in ("operator", "reader"))
        shell(folder, f"{sightline} {reader} scene import yard quad.obj --up z", fails=True)  # may only read
        shell(folder, f"{sightline} {operator} scene import yard quad.obj --up z")
        before = shell(folder, f"{sightline} {reader} cast yard --in - --out -", RAYS)
        scrape(admin)
    with running(folder, sightlined) as (flags, _):
        operator = f"{flags} --token-file operator.token"
        after = shell(folder, f"{sightline} {operator} cast yard --in - --out -", RAYS)
        shell(folder, f"{sightline} {operator} backup copy")
        shell(folder, "cd copy && sha256sum -c SHA256SUMS")
    shutil.rmtree(folder / "data")
    print("$ rm -r data")
    with running(folder, sightlined) as (flags, _):
        operator = f"{flags} --token-file operator.token"
        shell(folder, f"{sightline} {operator} restore copy")
        restored = shell(folder, f"{sightline} {operator} cast yard --in - --out -", RAYS)
    shell(folder, f"{sightlined} doctor data")
    if not before == after == restored or ",1," not in before:
        sys.exit("failed: the answers differ")


def main():
    needs("openssl")
    with tempfile.TemporaryDirectory() as folder:
        tour(pathlib.Path(folder), *map(shlex.quote, sys.argv[1:3]))


main()
