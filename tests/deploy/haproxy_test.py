#!/usr/bin/env python3
"""HAProxy takes its configuration."""

import os

from operator_files import DEPLOY, needs, run

needs("haproxy")
os.environ["SIGHTLINE_BIND"] = "127.0.0.1:50151"
for number, name in enumerate("ABC"):
    os.environ[f"SIGHTLINE_REPLICA_{name}"] = f"127.0.0.1:{50251 + number}"
    os.environ[f"SIGHTLINE_ADMIN_{name}"] = str(50351 + number)
run("haproxy", "-c", "-f", DEPLOY / "haproxy/haproxy.cfg")
