#!/usr/bin/env python3
"""The scrape configuration is valid, and each alert fires when it must and only then."""

from operator_files import DEPLOY, needs, run

import pathlib

needs("promtool")
run("promtool", "check", "config", DEPLOY / "prometheus/prometheus.yml")
run("promtool", "test", "rules", pathlib.Path(__file__).parent / "sightline_alerts_test.yml")
