#!/usr/bin/env python3
"""The commands of docs/security.md make certificates with which a server and a client talk.

certificates_test.py SIGHTLINED SIGHTLINE
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/security.md"
LISTEN, ENDPOINT = "--listen 0.0.0.0:50151", "localhost:50151"


def blocks():
    return re.findall(r"^```sh\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)


def script():
    """What a reader types. The server gets a free port, which the client is told when it is ready."""
    lines = ["set -eum", "trap 'kill $(jobs -p) 2> /dev/null || true' EXIT"]
    for block in blocks():
        lines.append(block.replace(LISTEN, "--listen 127.0.0.1:0 --port-file port")
                     .replace(" &\n", " &\nuntil [ -s port ]; do kill -0 %1; sleep 0.01; done\n")
                     .replace(ENDPOINT, "localhost:$(cat port)"))
    # Neither a client without a certificate is let in, nor one whose certificate another authority has signed.
    lines += ["""
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=robot-7 -keyout own.key -out own.pem
call="sightline --deadline 5 --endpoint localhost:$(cat port)"
if $call --tls-ca ca.pem scene ls; then exit 70; fi
if $call --tls-ca ca.pem --tls-cert own.pem --tls-key own.key scene ls; then exit 71; fi
if $call --tls-ca own.pem --tls-cert robot.pem --tls-key robot.key scene ls; then exit 72; fi
kill %1
wait %1
"""]
    return "\n".join(lines)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if shutil.which("openssl") is None:
        print("skipped: there is no openssl")
        sys.exit(77)
    text = "".join(blocks())
    for wanted in (LISTEN, ENDPOINT):
        assert wanted in text, f"the page has no {wanted}, which this test replaces"
    folders = ":".join(str(pathlib.Path(name).resolve().parent) for name in sys.argv[1:])
    environment = {name: value for name, value in os.environ.items() if not name.startswith("SIGHTLINE")}
    environment["PATH"] = f"{folders}:{environment['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        ran = subprocess.run(["bash", "-c", script()], cwd=folder, env=environment, capture_output=True, text=True,
                             check=False)
        print(ran.stdout, ran.stderr)
        assert ran.returncode == 0, f"exit code {ran.returncode}"
        assert ran.stdout.count("server.pem: OK") == 1 and ran.stdout.count("robot.pem: OK") == 1
        assert "sightline.example.org does match certificate" in ran.stdout
        assert len(re.findall(r"^SCENE ", ran.stdout, re.MULTILINE)) == 2, "both calls were answered"
        for key in ("ca.key", "server.key", "robot.key"):
            assert pathlib.Path(folder, key).stat().st_mode & 0o077 == 0, f"others may read {key}"


main()
