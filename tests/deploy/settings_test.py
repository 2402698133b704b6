#!/usr/bin/env python3
"""The settings that deploy/systemd installs are taken by the program, without a word about them."""

import sys

from operator_files import DEPLOY, run

said = run(sys.argv[1], "--config", DEPLOY / "systemd/sightlined.toml", "--check-config")
if said != "sightlined: the settings are good\n":
    sys.exit(f"failed: {said}")
printed = run(sys.argv[1], "--config", DEPLOY / "systemd/sightlined.toml", "--print-config")
if 'data-dir = "/var/lib/sightline"  # file ' not in printed:
    sys.exit(f"failed: {printed}")
