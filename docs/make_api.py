#!/usr/bin/python3
"""Writes docs/api.md, the reference of the messages and services, from the comments of proto/sightline/v1.

  docs/make_api.py            writes the page
  docs/make_api.py --check    1 and what to do, if the page is not what would be written

Needs protoc and python3-protobuf; 77 where one is missing.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "api.md"
FILES = ("query", "scene", "blob", "server", "backup", "common")  # as a reader meets them
INTRODUCTION = """# API reference

Package `sightline.v1`, made from the comments in [`proto/sightline/v1`](../proto/sightline/v1) by `docs/make_api.py`. [The wire](wire.md)
explains how calls work together, and lists errors and limits.
"""

# Numbers of fields in descriptor.proto, of which paths to comments are made.
FILE_MESSAGE, FILE_ENUM, FILE_SERVICE = 4, 5, 6
MESSAGE_FIELD, MESSAGE_ONEOF = 2, 8
ENUM_VALUE, SERVICE_METHOD = 2, 2


def describe():
    """The descriptors of FILES, with their comments, by name."""
    from google.protobuf import descriptor_pb2

    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "set"
        subprocess.run(["protoc", f"-I{ROOT / 'proto'}", "--include_source_info", f"--descriptor_set_out={out}",
                        *(f"sightline/v1/{name}.proto" for name in FILES)], check=True)
        described = descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())
    return {pathlib.Path(file.name).stem: file for file in described.file}


class Comments:
    """What is said of each part of a file."""

    def __init__(self, file):
        self._at = {tuple(location.path): location for location in file.source_code_info.location}

    def paragraphs(self, *path):
        """Of a service, message or enum: a list; what stands before it on its own comes first."""
        location = self._at.get(path)
        if location is None:
            return []
        texts = [*location.leading_detached_comments, location.leading_comments, location.trailing_comments]
        return [flow(part) for text in texts for part in re.split(r"\n\s*\n", text) if part.strip()]

    def line(self, *path):
        """Of a field or value: one line, for a table."""
        return " ".join(self.paragraphs(*path)).replace("|", "\\|")


def flow(text):
    """One line of Markdown that shows the text as it is."""
    return re.sub(r"([<*])", r"\\\1", " ".join(text.split()))


def table(head, rows):
    return ["", "| " + " | ".join(head) + " |", "|" + " --- |" * len(head), *(f"| {' | '.join(row)} |" for row in rows)]


def link(type_name):
    """`.sightline.v1.Rays` as a link to its heading."""
    name = type_name.rpartition(".")[2]
    return f"[{name}](#{name.lower()})"


def type_of(field):
    """`repeated double`, or a link to a message or an enum."""
    name = link(field.type_name) if field.type_name else field.Type.Name(field.type)[len("TYPE_"):].lower()
    if field.label == field.LABEL_REPEATED:
        return f"repeated {name}"
    return f"optional {name}" if field.proto3_optional else name


def service(comments, at, described):
    lines = ["", f"## {described.name}"]
    for paragraph in comments.paragraphs(FILE_SERVICE, at):
        lines += ["", paragraph]
    for number, method in enumerate(described.method):
        request = "stream of " * method.client_streaming + link(method.input_type)
        response = "stream of " * method.server_streaming + link(method.output_type)
        lines += ["", f"### {method.name}", "", f"{request} → {response}"]
        for paragraph in comments.paragraphs(FILE_SERVICE, at, SERVICE_METHOD, number):
            lines += ["", paragraph]
    return lines


def message(comments, at, described):
    lines = ["", f"### {described.name}"]
    for paragraph in comments.paragraphs(FILE_MESSAGE, at):
        lines += ["", paragraph]
    rows = []
    for number, field in enumerate(described.field):
        is_choice = field.HasField("oneof_index") and not field.proto3_optional
        choice = f" (one of `{described.oneof_decl[field.oneof_index].name}`)" if is_choice else ""
        rows.append((str(field.number), f"`{field.name}`", type_of(field) + choice,
                     comments.line(FILE_MESSAGE, at, MESSAGE_FIELD, number)))
    for number, oneof in enumerate(described.oneof_decl):
        said = comments.line(FILE_MESSAGE, at, MESSAGE_ONEOF, number)
        if said:
            lines += ["", f"`{oneof.name}`: {said}"]
    return lines + (table(("", "field", "type", ""), rows) if rows else ["", "No fields."])


def enum(comments, at, described):
    lines = ["", f"### {described.name}"]
    for paragraph in comments.paragraphs(FILE_ENUM, at):
        lines += ["", paragraph]
    rows = [(str(value.number), f"`{value.name}`", comments.line(FILE_ENUM, at, ENUM_VALUE, number))
            for number, value in enumerate(described.value)]
    return lines + table(("", "value", ""), rows)


def page():
    """The whole page: services first, then messages and enums by file."""
    files = describe()
    lines = INTRODUCTION.splitlines()
    for name in FILES:
        for at, described in enumerate(files[name].service):
            lines += service(Comments(files[name]), at, described)
    for name in FILES:
        lines += ["", f"## Messages of {name}.proto"]
        for kind, described_all in ((enum, files[name].enum_type), (message, files[name].message_type)):
            for at, described in enumerate(described_all):
                lines += kind(Comments(files[name]), at, described)
    return "\n".join(lines) + "\n"


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    try:
        import google.protobuf  # noqa: F401
    except ImportError as missing:
        print(f"skipped: {missing}")
        sys.exit(77)
    if shutil.which("protoc") is None:
        print("skipped: protoc is missing")
        sys.exit(77)
    made = page()
    if not sys.argv[1:]:
        PAGE.write_text(made)
    elif made != PAGE.read_text():
        sys.exit("docs/api.md is not what the comments in proto/sightline/v1 say: run docs/make_api.py")


if __name__ == "__main__":
    main()
