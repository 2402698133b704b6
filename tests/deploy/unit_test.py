#!/usr/bin/env python3
"""The unit is valid, and systemd finds little to say against its security."""

import pathlib
import sys
import tempfile

from operator_files import DEPLOY, needs, run

# Of 100: above 50 is MEDIUM in systemd's words.
MOST_EXPOSED = 20

needs("systemd-analyze")
with tempfile.TemporaryDirectory() as folder:
    # The program is where it was built, not where it is installed.
    unit = pathlib.Path(folder) / "sightlined.service"
    text = (DEPLOY / "systemd/sightlined.service").read_text()
    if "ExecStart=/usr/bin/sightlined " not in text:
        sys.exit("failed: the unit does not start the program")
    unit.write_text(text.replace("/usr/bin/sightlined", sys.argv[1]))
    said = run("systemd-analyze", "verify", "--man=no", unit)
    if said:
        sys.exit(f"failed: {said}")
    run("systemd-analyze", "security", "--offline=true", f"--threshold={MOST_EXPOSED}", unit)
