"""The files that the checks read, and C++ text in three views: code, comments, and what a namespace declares."""

import pathlib
import re

PRODUCT = ("proto", "accel", "scenegraph", "server", "client")

# Numbers come first, as 1'000 has no character literal in it.
_LEXEMES = re.compile(
    r"""(?P<number>(?<!\w)\d(?:'?[\w.])*)
      | (?P<comment>//(?:[^\n\\]|\\.|\\\n)* | /\*.*?\*/)
      | (?P<literal>(?:u8|[uUL])?R"(?P<mark>[^()\s\\]*)\(.*?\)(?P=mark)" | "(?:[^"\\\n]|\\.)*" | '(?:[^'\\\n]|\\.)*')
      | (?P<include>^[ \t]*\#[ \t]*include[^\n]*)""",
    re.VERBOSE | re.DOTALL | re.MULTILINE)


def files(root, folders, suffixes):
    """Paths below root, as POSIX strings relative to it, sorted."""
    root = pathlib.Path(root)
    found = []
    for folder in folders:
        found += [path.relative_to(root).as_posix() for path in (root / folder).rglob("*")
                  if path.suffix in suffixes and path.is_file()]
    return sorted(found)


def cpp_files(root, folders=(*PRODUCT, "tests", "docs")):
    return files(root, folders, {".h", ".cpp"})


def pages(root):
    root = pathlib.Path(root)
    found = [*root.glob("*.md"), *root.glob("docs/**/*.md")]
    return sorted(path.relative_to(root).as_posix() for path in found if "node_modules" not in path.parts)


def read(root, name):
    return (pathlib.Path(root) / name).read_text(encoding="utf-8")


def _blank(text):
    return re.sub(r"[^\n]", " ", text)


def code(text):
    """The text with comments, literals and includes blanked: every line and column stays where it is."""
    return _LEXEMES.sub(lambda m: m[0] if m["number"] else _blank(m[0]), text)


def comments(text):
    """The text with everything but its comments blanked."""
    kept, end = [], 0
    for match in _LEXEMES.finditer(text):
        kept.append(_blank(text[end:match.start()]))
        kept.append(match[0] if match["comment"] else _blank(match[0]))
        end = match.end()
    return "".join(kept) + _blank(text[end:])


def includes(text):
    """Lines, headers, and whether they stand in quotes."""
    for match in re.finditer(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"\n]+)[>"]', text, re.MULTILINE):
        yield text.count("\n", 0, match.start()) + 1, match[2], match[1] == '"'


def line_of(text, position):
    return text.count("\n", 0, position) + 1
