#!/usr/bin/env python3
"""Every metric that the dashboard and the alerts ask for exists in a running server, and every query is valid.

None is asked for by a name that ends with the next version. Prometheus' linter has no complaint about names, helps and types.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

from operator_files import DEPLOY, metric_names, metrics, needs, run, server

# Metrics that Prometheus itself adds.
OWN = {"up"}
# Words of a query that are no metrics: functions and operators are followed by a bracket or a label list.
WORD = re.compile(r"(?<![\w$\"'])([a-zA-Z_:][\w:]*)(?!\s*\(|\w)")


def names_in(query):
    """The metrics that a query names."""
    bare = re.sub(r"\"[^\"]*\"", '""', query)
    bare = re.sub(r"\{[^}]*\}", "", bare)
    bare = re.sub(r"\[[^\]]*\]", "", bare)
    bare = re.sub(r"\b(by|on|without|ignoring)\s*\([^)]*\)", "", bare)
    return {name for name in WORD.findall(bare) if name not in {"and", "or", "unless"}}


def dashboard_queries():
    dashboard = json.loads((DEPLOY / "grafana/sightline.json").read_text())
    for variable in dashboard["templating"]["list"]:
        found = re.match(r"label_values\((\w+),", variable.get("definition", ""))
        if found:
            yield found[1]
    for panel in dashboard["panels"]:
        for target in panel.get("targets", []):
            yield target["expr"]


def alert_queries():
    text = (DEPLOY / "prometheus/sightline_alerts.yml").read_text()
    for block in re.findall(r"expr: (\|\n(?: {10,}.*\n)+|.*\n)", text):
        yield block.removeprefix("|\n")


def check_syntax(queries):
    """promtool knows rules, not dashboards: each query becomes one."""
    rules = [{"record": f"query_{i}", "expr": query.replace("$__rate_interval", "5m").replace("$instance", ".*")}
             for i, query in enumerate(queries)]
    with tempfile.NamedTemporaryFile("w", suffix=".yml") as file:
        json.dump({"groups": [{"name": "dashboard", "rules": rules}]}, file)  # JSON is YAML
        file.flush()
        run("promtool", "check", "rules", file.name)


def main():
    needs("promtool")
    needs("openssl")
    dashboard, alerts = list(dashboard_queries()), list(alert_queries())
    if len(dashboard) < 20 or len(alerts) < 10:
        sys.exit("failed: the queries were not found")
    check_syntax(dashboard)
    # What is not set has no metrics.
    with tempfile.TemporaryDirectory() as folder:
        settings, certificate, key = (f"{folder}/{name}" for name in ("settings.toml", "own.pem", "own.key"))
        pathlib.Path(settings).write_text("[quota]\nconcurrent-work = 1000\n")
        run("openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-subj", "/CN=localhost", "-keyout", key,
            "-out", certificate)
        with server(sys.argv[1], "--config", settings, "--data-dir", f"{folder}/data", "--tls-cert", certificate,
                    "--tls-key", key, "--metrics-per-scene") as url:
            text = metrics(url)
    linted = subprocess.run(["promtool", "check", "metrics"], input=text, text=True, capture_output=True, check=False)
    if linted.returncode != 0 or linted.stdout or linted.stderr:
        sys.exit(f"failed: {linted.stdout}{linted.stderr}")
    current = re.sub(r"(?m)^# HELP (\w+) Deprecated, .*\n# TYPE .*\n(\1.*\n)+", "", text)
    if "rays_total" not in metric_names(text) or "rays_total" in metric_names(current):
        sys.exit("failed: the old names were not found")
    there = metric_names(current) | OWN
    missing = {(name, query) for query in dashboard + alerts for name in names_in(query) - there}
    for name, query in sorted(missing):
        print(f"{name} is no metric of the server: {query}")
    sys.exit(1 if missing else 0)


main()
