"""What pages link to, sections of pages included, and every `path/file.ext` that they name, exists."""

import collections
import functools
import pathlib
import re

from sources import line_of, pages, read

_LINK = re.compile(r"\]\(([^()\s]+)\)")
_PATH = re.compile(r"`((?:accel|scenegraph|server|client|proto|tests|docs|deploy)/[\w/]+\.(?:h|cpp|proto|txt|md|py|csv))`")


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


@functools.cache
def sections(text):
    """The fragments by which GitHub knows the headings of a page's text."""
    found, seen = set(), collections.Counter()
    text = re.sub(r"^```.*?^```", blank, text, flags=re.DOTALL | re.MULTILINE)
    for heading in re.findall(r"^#{1,6} +(.*?) *$", text, flags=re.MULTILINE):
        name = re.sub(r"[^\w\- ]", "", re.sub(r"\]\([^()]*\)", "]", heading).lower()).replace(" ", "-")
        found.add(f"{name}-{seen[name]}" if seen[name] else name)
        seen[name] += 1
    return found


def check(root):
    root = pathlib.Path(root)
    findings = []
    for page in pages(root):
        text = read(root, page)
        for match in _LINK.finditer(re.sub(r"`[^`\n]*`", blank, text)):
            target, _, section = match[1].partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            linked = (root / page).parent / target if target else root / page
            if not linked.exists():
                findings.append(f"{page}:{line_of(text, match.start())}: links to {target}, which does not exist")
            elif section and linked.suffix == ".md" and section not in sections(linked.read_text(encoding="utf-8")):
                findings.append(f"{page}:{line_of(text, match.start())}: links to {match[1]}, a section that is gone")
        for match in _PATH.finditer(text):
            if not (root / match[1]).exists():
                findings.append(f"{page}:{line_of(text, match.start())}: names {match[1]}, which does not exist")
    return findings
