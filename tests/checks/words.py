"""Comments, names and pages use the field's terms: words.txt lists what is not used, and what to say instead."""

import functools
import pathlib
import re

from sources import PRODUCT, code, comments, cpp_files, line_of, pages, read

WORDS = pathlib.Path(__file__).with_name("words.txt")
OF_THE_LANGUAGE = {"promise_type"}


@functools.cache
def _rules():
    """What words.txt says: phrases and terms as patterns, and names in snake_case, with what to say instead."""
    patterns, names = {"phrase": [], "term": []}, {}
    for number, line in enumerate(WORDS.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        kind, words, instead = (part.strip() for part in line.split(" | "))
        if kind in patterns:
            pattern = words.replace(" ", r"\s+")
            patterns[kind].append((re.compile(rf"\b(?:{pattern})\b", re.IGNORECASE), instead))
        elif kind == "name":
            names[words] = instead
        else:
            raise ValueError(f"words.txt:{number}: {kind} is not phrase, term or name")
    return patterns, names


def snake_case(identifier):
    words = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", identifier)
    return re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", words).lower().strip("_")


def prose(page):
    """A Markdown page without its code, links and tables of contents."""
    page = re.sub(r"^```.*?^```|^    .*?$|`[^`\n]*`", lambda m: re.sub(r"[^\n]", " ", m[0]), page,
                  flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"\]\([^()\s]*\)", "]", page)


def joined(text):
    """Comments whose lines are one text, so that a phrase may go on in the next line; positions stay."""
    return re.sub(r"\n[ \t]*(//+)?", lambda m: " " * len(m[0]), re.sub(r"//", "  ", text))


def is_history(page):
    """Whether a page says what was called how when it was written."""
    return page == "CHANGELOG.md" or page.startswith("docs/decisions/")


def phrases_in(text, original, terms=True):
    patterns = _rules()[0]
    for pattern, instead in patterns["phrase"] + (patterns["term"] if terms else []):
        for match in pattern.finditer(text):
            yield line_of(original, match.start()), re.sub(r"\s+", " ", match[0]), instead


@functools.cache
def better_name(identifier):
    """What to say instead of a name or of a part of it, or None."""
    snake = f"_{snake_case(identifier)}_"
    return next((instead for name, instead in _rules()[1].items() if f"_{name}_" in snake), None)


def names_in(text):
    """The first use of each such name in code. What a package or the language has named is let alone."""
    seen = set()
    for match in re.finditer(r"\b(?:(?:std|tbb|hn|hwy|grpc|google)::)?([A-Za-z_]\w*)", text):
        name = match[1]
        if "::" not in match[0] and name not in seen | OF_THE_LANGUAGE and better_name(name):
            seen.add(name)
            yield line_of(text, match.start()), name, better_name(name)


def check(root):
    """What is found in all files, as a list."""
    return [finding for found in all_findings(root).values() for finding in found]


def all_findings(root):
    """{file: findings}."""
    findings = {}

    def report(file, found):
        for line, words, instead in sorted(found):
            findings.setdefault(file, []).append(f'{file}:{line}: "{words}": say {instead}')

    for file in cpp_files(root, (*PRODUCT, "tests")):
        text = read(root, file)
        stem = pathlib.PurePosixPath(file).stem
        report(file, phrases_in(joined(comments(text)), text))
        report(file, names_in(code(text)))
        if better_name(stem):
            report(file, [(1, stem, better_name(stem))])
    for page in pages(root):
        text = read(root, page)
        report(page, phrases_in(prose(text).replace("\n", " "), text, terms=not is_history(page)))
    return findings
