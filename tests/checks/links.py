"""What pages link to, and every `path/file.ext` that they name, exists."""

import pathlib
import re

from sources import line_of, pages, read

_LINK = re.compile(r"\]\(([^()\s]+)\)")
_PATH = re.compile(r"`((?:accel|scenegraph|server|client|proto|tests|docs|deploy)/[\w/]+\.(?:h|cpp|proto|txt|md|py|csv))`")


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def check(root):
    root = pathlib.Path(root)
    findings = []
    for page in pages(root):
        text = read(root, page)
        for match in _LINK.finditer(re.sub(r"`[^`\n]*`", blank, text)):
            target = match[1].split("#")[0]
            if target and not re.match(r"[a-z]+:", target) and not (root / page).parent.joinpath(target).exists():
                findings.append(f"{page}:{line_of(text, match.start())}: links to {target}, which does not exist")
        for match in _PATH.finditer(text):
            if not (root / match[1]).exists():
                findings.append(f"{page}:{line_of(text, match.start())}: names {match[1]}, which does not exist")
    return findings
