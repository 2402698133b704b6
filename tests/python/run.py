#!/usr/bin/env python3
"""Runs the tests of the Python package.

run.py SIGHTLINED PACKAGE [NAME...]    PACKAGE: the folder that has sightline; NAME as in `python3 -m unittest`

Exits with 77 where grpcio, protobuf or numpy are missing, after it has counted the tests that were skipped.
"""

import os
import pathlib
import re
import sys
import unittest

SYSTEM_PYTHON = "/usr/bin/python3"
HERE = pathlib.Path(__file__).resolve().parent


def is_complete():
    """Whether this interpreter has what the package needs; says what it lacks."""
    try:
        import google.protobuf
        import grpc
        import numpy
    except ImportError as missing:
        print(f"skipped: {missing}")
        return False
    return bool(grpc.__name__ and google.protobuf.__name__ and numpy.__name__)


def count_tests():
    return sum(len(re.findall(r"^    (?:async )?def test_", file.read_text(), re.MULTILINE))
               for file in HERE.glob("*_test.py"))


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    if not is_complete():
        # The distribution's interpreter sees its packages, which another one first in PATH does not.
        if os.path.exists(SYSTEM_PYTHON) and os.path.realpath(sys.executable) != os.path.realpath(SYSTEM_PYTHON):
            os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])
        print(f"{count_tests()} tests are not run")
        sys.exit(77)
    os.environ["SIGHTLINED"] = os.path.abspath(sys.argv[1])
    os.environ["PYTHONPATH"] = os.path.abspath(sys.argv[2])  # of processes that tests start
    for name in ("SIGHTLINE_ENDPOINT", "SIGHTLINE_TOKEN"):
        os.environ.pop(name, None)
    sys.dont_write_bytecode = True
    sys.path[:0] = [os.environ["PYTHONPATH"], str(HERE)]
    names = sys.argv[3:]
    suite = (unittest.defaultTestLoader.loadTestsFromNames(names) if names
             else unittest.defaultTestLoader.discover(str(HERE), "*_test.py"))
    sys.exit(0 if unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful() else 1)


if __name__ == "__main__":
    main()
