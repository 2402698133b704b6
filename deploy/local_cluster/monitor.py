"""Prometheus: scrapes the replicas, and evaluates the alerts of deploy/prometheus."""

from . import programs
from .processes import Process, answers
from .settings import REPLICAS

_CONFIGURATION = """\
global:
  scrape_interval: 5s
  evaluation_interval: 5s

rule_files:
  - {alerts}

scrape_configs:
  - job_name: sightline
    static_configs:
{targets}
"""
_TARGET = '      - targets: ["127.0.0.1:{port}"]\n        labels: {{replica: "{name}"}}'


class Monitor:
    def __init__(self, settings):
        self._settings = settings
        self.process = Process(settings.directory, "prometheus")

    def up(self):
        ports = self._settings.ports
        file = self._settings.directory / "prometheus.yml"
        targets = "\n".join(_TARGET.format(port=ports[f"admin-{name}"], name=name) for name in REPLICAS)
        file.write_text(_CONFIGURATION.format(alerts=programs.DEPLOY / "prometheus/sightline_alerts.yml", targets=targets))
        self.process.start(
            [programs.find("prometheus"), f"--config.file={file}", f"--storage.tsdb.path={self._settings.directory / 'prometheus'}",
             f"--web.listen-address=127.0.0.1:{ports['prometheus']}", "--storage.tsdb.retention.time=2d"])
        self.process.must_run_until(lambda: answers(f"http://127.0.0.1:{ports['prometheus']}/-/ready"), 60)

    def down(self):
        self.process.stop(seconds=10)
