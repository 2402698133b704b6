#!/usr/bin/env python3
"""All files and pages that name an admin port name the one that operations.md does."""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# A number after a word for the admin port, in any of the forms that flags, variables, YAML and TOML have; and the targets of a scrape.
NAMED = re.compile(r"(?:--admin|SIGHTLINED_ADMIN|SIGHTLINE_ADMIN_\w|\badmin\b|prometheus\.io/port|targets)[^\n]{0,40}?[\s:\"](\d{4,5})\b")
# A number before a path of the admin port.
ASKED = re.compile(r":(\d{4,5})/(?:livez|readyz|metrics)\b")
SUFFIXES = {".md", ".py", ".sh", ".toml", ".yaml", ".yml", ".json", ".service", ".cfg", ""}


def files():
    yield ROOT / "README.md"
    for folder in ("deploy", "docs"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and path.suffix in SUFFIXES and "data" not in path.parts:
                yield path


def main():
    operations = (ROOT / "docs/operations.md").read_text()
    port = re.search(r"--admin 127\.0\.0\.1:(\d+)", operations)[1]
    found, wrong = 0, []
    for path in files():
        text = path.read_text()
        for match in [*NAMED.finditer(text), *ASKED.finditer(text)]:
            found += 1
            if match[1] != port:
                wrong.append(f"{path.relative_to(ROOT)} names {match[1]}: {match[0].strip()}")
    print("\n".join(wrong))
    assert found >= 15, f"{found} admin ports found: are they named in another way?"
    sys.exit(1 if wrong else 0)


main()
