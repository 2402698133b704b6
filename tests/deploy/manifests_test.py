#!/usr/bin/env python3
"""The Kubernetes manifests fit the types of Kubernetes' own client, and themselves; the settings in them are the server's.

manifests_test.py SIGHTLINED

kubectl --dry-run=client asks a cluster what kinds there are, so it cannot be used without one. It renders kustomizations alone.
"""

import importlib
import os
import re
import shutil
import subprocess
import sys

from operator_files import DEPLOY, SKIPPED, run

SYSTEM_PYTHON = "/usr/bin/python3"
# Kinds, and the classes that Debian 12's client has for them: its Kubernetes is 1.22, in which autoscaling/v2 still has the name that
# it had before it was declared stable, without a change.
CLASSES = {("v1", "Service"): "V1Service", ("apps/v1", "Deployment"): "V1Deployment", ("apps/v1", "StatefulSet"): "V1StatefulSet",
           ("policy/v1", "PodDisruptionBudget"): "V1PodDisruptionBudget",
           ("autoscaling/v2", "HorizontalPodAutoscaler"): "V2beta2HorizontalPodAutoscaler",
           ("networking.k8s.io/v1", "NetworkPolicy"): "V1NetworkPolicy"}
PLAIN = {"str": str, "int": int, "bool": bool, "float": (int, float)}


def check(client, kind, value, where):
    """Names what does not fit, else makes the object, which checks what is required. Returns it."""
    if kind in PLAIN:
        if not isinstance(value, PLAIN[kind]) or isinstance(value, bool) != (kind == "bool"):
            sys.exit(f"failed: {where} is not {kind}: {value!r}")
        return value
    if kind == "object":  # a number or a string, such as a port
        return value
    inner = re.fullmatch(r"list\[(.*)\]|dict\(str, (.*)\)", kind)
    if inner and inner[1]:
        return [check(client, inner[1], one, f"{where}[{number}]") for number, one in enumerate(value)]
    if inner:
        return {key: check(client, inner[2], one, f"{where}.{key}") for key, one in value.items()}
    model = getattr(client, kind)
    names = {key: attribute for attribute, key in model.attribute_map.items()}
    for key in value:
        if key not in names:
            sys.exit(f"failed: {where} has no {key}")
    fields = {names[key]: check(client, model.openapi_types[names[key]], one, f"{where}.{key}") for key, one in value.items()}
    try:
        return model(**fields)
    except ValueError as error:
        sys.exit(f"failed: {where}: {error}")


def check_pods(workload, documents):
    """Labels select, named ports exist, nothing is written to but volumes."""
    template = workload.spec.template
    container, = template.spec.containers
    ports = {port.name for port in container.ports}
    for probe in (container.startup_probe, container.liveness_probe, container.readiness_probe):
        if probe.http_get.port not in ports:
            sys.exit(f"failed: {workload.metadata.name} is probed at {probe.http_get.port}, which it does not have")
    if not container.security_context.read_only_root_filesystem or not template.spec.security_context.run_as_non_root:
        sys.exit(f"failed: {workload.metadata.name} may write to its root, or be root")
    volumes = {volume.name for volume in [*(template.spec.volumes or [])]}
    volumes |= {claim.metadata.name for claim in getattr(workload.spec, "volume_claim_templates", None) or []}
    if {mount.name for mount in container.volume_mounts} != volumes:
        sys.exit(f"failed: {workload.metadata.name} mounts other volumes than it has")
    for other in documents:
        selector = getattr(other.spec, "selector", None) or getattr(other.spec, "pod_selector", None)
        wanted = getattr(selector, "match_labels", selector)
        if other.spec is not None and wanted is not None and not wanted.items() <= template.metadata.labels.items():
            sys.exit(f"failed: {other.kind} {other.metadata.name} selects other pods")
    return container


def check_settings(program, container):
    """The server takes them, and knows them all. Secrets are not here."""
    settings = {one.name: one.value if one.value is not None else "postgresql://sightline@db/sightline" for one in container.env}
    known = {"PATH": os.environ["PATH"], **settings}
    done = subprocess.run([program, "--print-config"], env=known, text=True, capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(f"failed: {done.stdout}{done.stderr}")
    for name in settings:
        if f"# environment {name}\n" not in done.stdout:
            sys.exit(f"failed: {name} is no setting")


def rendered(name):
    """The text of all objects of a kustomization; None: there is no kubectl. Debian 12's is of 2020, and knows other words."""
    return None if shutil.which("kubectl") is None else run("kubectl", "kustomize", str(DEPLOY / "kubernetes" / name))


def check_site(yaml, documents):
    """The example changes what it names, and all of it."""
    wanted = yaml.safe_load((DEPLOY / "kubernetes/site/kustomization.yaml").read_text())
    size, = yaml.safe_load((DEPLOY / "kubernetes/site/size.yaml").read_text())["spec"]["template"]["spec"]["containers"]
    if {one.metadata.namespace for one in documents} != {wanted["namespace"]}:
        sys.exit("failed: an object of the site is in another namespace")
    deployment, = (one for one in documents if one.kind == "Deployment")
    container, = deployment.spec.template.spec.containers
    image, = wanted["images"]
    if container.image != f"{image['newName']}:{image['newTag']}":
        sys.exit(f"failed: the site has the image {container.image}")
    values = {one.name: one.value for one in container.env}
    for one in size["env"]:
        if values[one["name"]] != one["value"]:
            sys.exit(f"failed: the site has {one['name']}={values[one['name']]}")
    if container.resources.limits != size["resources"]["limits"] or len(values) < 10:
        sys.exit("failed: the site lost settings, or its size")


def main():
    try:
        yaml = importlib.import_module("yaml")
        client = importlib.import_module("kubernetes.client")
    except ImportError as error:
        # The distribution's interpreter sees its packages, which another one first in PATH does not.
        if os.path.exists(SYSTEM_PYTHON) and os.path.realpath(sys.executable) != os.path.realpath(SYSTEM_PYTHON):
            os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])
        print(f"skipped: {error}")
        sys.exit(SKIPPED)
    checked = 0
    folders = sorted(file.parent for file in (DEPLOY / "kubernetes").glob("*/kustomization.yaml"))
    if [folder.name for folder in folders] != ["embedded", "replicas", "site"]:
        sys.exit("failed: the kustomizations are others than this test knows")
    for folder in folders:
        listed = yaml.safe_load((folder / "kustomization.yaml").read_text())["resources"]
        text = rendered(folder.name) or "".join((folder / one).read_text() for one in listed if not one.startswith("../"))
        documents = [check(client, CLASSES[one["apiVersion"], one["kind"]], one, f"{folder.name}: {one['kind']}")
                     for one in yaml.safe_load_all(text)]
        if folder.name == "site":
            if not documents:
                print("the site is not rendered: there is no kubectl")
                continue
            check_site(yaml, documents)
        workload, = (one for one in documents if one.kind in ("Deployment", "StatefulSet"))
        check_settings(sys.argv[1], check_pods(workload, documents))
        checked += len(documents)
    services = yaml.safe_load((DEPLOY / "container/compose.yaml").read_text())["services"]
    for name in ("a", "b", "c"):
        if not services[name]["read_only"]:
            sys.exit(f"failed: {name} may write to its root")
    rules = yaml.safe_load((DEPLOY / "prometheus/adapter_rules.yml").read_text())["rules"]
    scaled = (DEPLOY / "kubernetes/replicas/replicas.yaml").read_text()
    if f"name: {rules[0]['name']['as']}" not in scaled:
        sys.exit("failed: the replicas are scaled by another metric than the adapter makes")
    print(f"{checked} objects")


main()
