"""Namespaces follow folders, and each type is defined once in its namespace over all files.

accel/kdtree/slot.h opens sightline::accel::kdtree and defines nothing outside it. Another room's namespace, or a
package's, is opened to declare a type or to specialise a template, never to define something. Tests are in the namespace
of what they test, or in sightline::tests or sightline::bench.
"""

import collections
import pathlib
import re

from sources import PRODUCT, code, cpp_files, line_of, read

Statement = collections.namedtuple("Statement", "namespace line kind name")
# Kinds: "opens" a namespace, "declares" or "defines" a type, "other" for functions, variables and specialisations.

_UNNAMED = "(unnamed)"
_PREPROCESSOR = re.compile(r"^[ \t]*#(?:[^\n\\]|\\.|\\\n)*", re.MULTILINE | re.DOTALL)
_TYPE = re.compile(
    r"""^(?P<template>template\s*<.*>\s*(?:requires\b.*?)?)?
        (?:class|struct|union|enum(?:\s+(?:class|struct))?)\b\s*
        (?:alignas\s*\([^()]*\)\s*|\[\[.*?\]\]\s*)*
        (?P<name>[\w:]+)(?P<arguments>\s*<.*>)?\s*
        (?:final\s*)?(?::(?!:).*)?$""",
    re.VERBOSE | re.DOTALL)
_NAMESPACE = re.compile(r"^(?:inline\s+)?namespace\b\s*([\w:]*)$")
# What defines nothing, and what has C linkage, whose literal is blank here.
_IGNORED = re.compile(
    r"^(?:using|typedef|static_assert|namespace|extern\s+template|catch)\b|^extern\s{3,}")
_MACRO = re.compile(r"^[A-Z][A-Z0-9_]*\s*(?:\(|$)")
# What follows the body of a type or a function and belongs to it, up to a semicolon or the next body.
_GOES_ON = re.compile(r"\s*[;,{]|\s*\w*\s*=")


def statements(text):
    """What a file has at the level of namespaces, in order; the bodies of functions and types are passed by."""
    text = code(text)
    text = _PREPROCESSOR.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    scopes, start, brackets, braces, goes_on = [], 0, 0, 0, False
    for match in re.finditer(r"[{};()]", text):
        token, head = match[0], text[start:match.start()]
        line = line_of(text, match.start() - len(head.lstrip()))
        head = head.strip()
        if braces:
            braces += {"{": 1, "}": -1}.get(token, 0)
            if not braces:
                start, goes_on = match.end(), _GOES_ON.match(text, match.end()) is not None
        elif token in "()":
            brackets += 1 if token == "(" else -1
        elif brackets:
            pass
        elif token == "{" and (opened := _NAMESPACE.match(head)):
            scopes.append(opened[1] or _UNNAMED)
            yield Statement("::".join(scopes), line, "opens", scopes[-1])
            start = match.end()
        elif token == "{" and re.fullmatch(r'extern\b\s*', head):  # extern "C", its literal blanked
            scopes.append(_UNNAMED)
            start = match.end()
        elif token == "}":
            if scopes:
                scopes.pop()
            start, goes_on = match.end(), False
        else:
            if not goes_on:
                yield from _statement("::".join(scopes), line, head, has_body=token == "{")
            if token == "{":
                braces = 1
            start, goes_on = match.end(), False


def _statement(namespace, line, head, has_body):
    if not head or _IGNORED.match(head) or (_MACRO.match(head) and not has_body):
        return
    described = _TYPE.match(head)
    if described and not described["arguments"] and "::" not in described["name"]:
        yield Statement(namespace, line, "defines" if has_body else "declares", described["name"])
    else:
        names = re.findall(r"[A-Za-z_][\w:]*", head.split("(")[0].split("=")[0])
        yield Statement(namespace, line, "other", described["name"] if described else names[-1] if names else head)


def own_namespace(file):
    """The namespace of a file's folder."""
    return "::".join(["sightline", *file.split("/")[:-1]])


def named(namespace):
    """A namespace without what is unnamed, or Highway's, in it."""
    return re.sub(r"(^|::)(\(unnamed\)|HWY_NAMESPACE)(::.*)?$", "", namespace)


# What the language wants there: main, and replacements of operator new and delete.
GLOBAL = ("main", "new", "delete")

# Result and Error belong to all folders.
SHARED = {"proto/printable.h": "sightline", "proto/result.h": "sightline"}


def may_define(file, namespace):
    if namespace == SHARED.get(file):
        return True
    if namespace == own_namespace(file.removeprefix("tests/")):
        return True
    return not file.startswith(PRODUCT) and re.match(r"sightline::(tests|bench)(::|$)", namespace) is not None


def check_file(root, file, found):
    """Findings in a file, given what it has."""
    by_namespace = collections.defaultdict(list)
    for statement in found:
        if statement.namespace != _UNNAMED:
            by_namespace[named(statement.namespace)].append(statement)
    for namespace, inside in by_namespace.items():
        kinds = {statement.kind for statement in inside} - {"opens"}
        first = inside[0]
        if namespace == "":
            for statement in inside:
                qualified = "::" in statement.name or statement.kind == "declares"
                if statement.kind != "opens" and not qualified and statement.name not in GLOBAL:
                    yield f"{file}:{statement.line}: {statement.name} is defined outside any namespace"
        elif namespace.startswith("sightline"):
            folder = pathlib.Path(root, *namespace.split("::")[1:])
            declares_only = kinds == {"declares"} and (folder.is_dir() or namespace == "sightline::v1")
            if kinds and not may_define(file, namespace) and not declares_only:
                yield f"{file}:{first.line}: is in {namespace}, the namespace of its folder is " \
                      f"{own_namespace(file.removeprefix('tests/'))}"
        elif "defines" in kinds:
            yield f"{file}:{first.line}: defines a type in {namespace}"


def check(root):
    findings, types = [], collections.defaultdict(dict)
    for file in cpp_files(root, (*PRODUCT, "tests")):
        found = list(statements(read(root, file)))
        findings += check_file(root, file, found)
        for statement in found:
            if statement.kind == "defines" and _UNNAMED not in statement.namespace:
                types[statement.namespace, statement.name].setdefault(file, statement.line)
    for (namespace, name), places in sorted(types.items()):
        if len(places) > 1:
            where = " and ".join(f"{file}:{line}" for file, line in sorted(places.items()))
            findings.append(f"{where}: {namespace}::{name} is defined {len(places)} times")
    return findings
