"""docs/ray_path.md names only files and folders that exist, has its three walks, and leaves out no room."""

import pathlib
import re

from sources import PRODUCT, cpp_files, line_of, read

PAGE = "docs/ray_path.md"
# A heading for each walk, and the least number of files below it.
WALKS = {"ray": 5, "update": 5, "build": 3}
_FILE = re.compile(r"(?<![\w./])((?:[\w-]+/)*[\w-]+\.(?:h|cpp|proto)|(?:[\w-]+/)*[\w-]+\.\{[\w,]+\})")


def named_files(text):
    """Positions and paths; `a.{h,cpp}` names two."""
    for match in _FILE.finditer(text):
        stem, endings = match[1].rsplit(".", 1)
        for ending in endings.strip("{}").split(","):
            yield match.start(), f"{stem}.{ending}"


def sections(text):
    """Headings in lower case, with the text below each down to the next."""
    parts = re.split(r"^#+ *(.*)$", text, flags=re.MULTILINE)
    return [(heading.lower(), body) for heading, body in zip(parts[1::2], parts[2::2])]


def check(root):
    root = pathlib.Path(root)
    if not (root / PAGE).exists():
        return [f"{PAGE} does not exist"]
    text = read(root, PAGE)
    findings = []

    # A file is named by its path from the root, or by its name alone where its folder has been named.
    sources = cpp_files(root) + [path.relative_to(root).as_posix() for path in root.glob("proto/**/*.proto")]
    names = {pathlib.PurePosixPath(source).name for source in sources}
    for position, file in named_files(text):
        if file not in (sources if "/" in file else names):
            findings.append(f"{PAGE}:{line_of(text, position)}: {file} does not exist")

    for walk, least in WALKS.items():
        found = [len({file for _, file in named_files(body)}) for heading, body in sections(text)
                 if re.search(rf"\b{walk}s?\b", heading)]
        if not found or max(found) < least:
            findings.append(f"{PAGE}: no walk of {walk!r}, or fewer than {least} files in it")

    folders = {source.rsplit("/", 1)[0] for source in cpp_files(root, PRODUCT)}
    for folder in sorted(folders):
        # By itself, not as the folder of a file.
        if not re.search(rf"(?<![\w/]){re.escape(folder)}/?(?![\w/-])", text):
            findings.append(f"{PAGE}: {folder} is not named")
    return findings
