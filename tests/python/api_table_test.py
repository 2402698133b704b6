"""docs/api_table.md names every call, field and value of the messages, and nothing that is not there."""

import inspect
import pathlib
import re
import subprocess
import unittest

import sightline
import sightline.aio
from shared import COMMAND
from sightline import _proto

ROOT = pathlib.Path(__file__).resolve().parents[2]
OBJECTS = {"client": sightline.Client, "scene": sightline.Scene, "stream": sightline.UpdateStream}
AWAITED = {"client": sightline.aio.Client, "scene": sightline.aio.Scene, "stream": sightline.aio.UpdateStream}
TITLES = ["command", "C++", "Python", "aio"]


def read_rows():
    """The rows of all tables, as lists of cells; the first row of each table names the columns."""
    lines = [line for line in (ROOT / "docs/api_table.md").read_text().splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if not line.startswith("| ---")]


def fields_of_requests():
    """"Message.field" of all that a request may hold."""
    found, waiting = set(), [method.request.DESCRIPTOR for method in _proto.methods.values()]
    seen = {message.full_name for message in waiting}
    while waiting:
        message = waiting.pop()
        for field in message.fields:
            found.add(f"{message.name}.{field.name}")
            inner = field.message_type
            if inner is not None and inner.full_name not in seen:
                seen.add(inner.full_name)
                waiting.append(inner)
    return found


def words_of_enumerations():
    """"Enumeration.VALUE" of all that say something."""
    found = set()
    for file in _proto.files.file:
        for enumeration in file.enum_type if file.package == _proto.PACKAGE else ():
            prefix = re.sub(r"(?<!^)(?=[A-Z])", "_", enumeration.name).upper() + "_"
            found.update(f"{enumeration.name}.{value.name[len(prefix):]}" for value in enumeration.value if value.number)
    return found


def resolve(word, objects):
    """What `scene.cast` or `sightline.Pinhole` is; AttributeError."""
    first, *others = word.split(".")
    found = objects.get(first, sightline)
    for name in others:
        found = getattr(found, name)
    return found


class ApiTableTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.rows = [row for row in read_rows() if row[0] not in ("call", "field", "values")]

    def test_every_call_and_field_has_one_row(self):
        named = []
        for first, *_ in self.rows:
            message, colon, fields = first.partition(":")
            if colon:
                named += [f"{message.strip('`')}.{field}" for field in re.findall(r"`(\w+)`", fields)]
            else:
                named.append(message.strip("`"))
        self.assertEqual(sorted(named), sorted(
            set(_proto.methods) | fields_of_requests() | words_of_enumerations()))

    def test_every_cell_says_something(self):
        for row in self.rows:
            with self.subTest(row[0]):
                self.assertEqual(len(row), 6 if row[0].strip("`") in _proto.methods else 5)
                for title, cell in zip([*TITLES, "JSON"], row[1:]):
                    self.assertTrue(cell, title)
                    self.assertNotRegex(cell, r"^[–-]\W*$", f"{title} has no reason")

    def test_json_has_the_calls_that_are_no_streams(self):
        for row in self.rows:
            name = row[0].strip("`")
            if name in _proto.methods:
                streams = _proto.methods[name].client_streaming or _proto.methods[name].server_streaming
                self.assertEqual(row[5], "– a stream" if streams else f"`POST /v1/json/{name}`")

    def test_python_has_what_is_named(self):
        for row in self.rows:
            for objects, cell in ((OBJECTS, row[3]), (AWAITED, row[4])):
                for word, parameter in re.findall(r"`((?:client|scene|stream|sightline)\.[\w.]+)(?:\((\w+)=\))?`", cell):
                    with self.subTest(word=word, parameter=parameter):
                        found = resolve(word, objects)
                        if parameter:
                            self.assertIn(parameter, inspect.signature(found).parameters)

    def test_cpp_has_what_is_named(self):
        files = [file for folder in ("client", "proto/rays") for file in (ROOT / folder).glob("*.h")]
        headers = "\n".join(file.read_text() for file in files)
        for row in self.rows:
            for word in [] if row[2].startswith("–") else re.findall(r"`([\w:]+)`", row[2]):
                for name in word.split("::"):
                    with self.subTest(word):
                        self.assertTrue(re.search(rf"\b{name}\b", headers), "no header has it")

    @unittest.skipUnless(COMMAND.exists(), "needs the command")
    def test_the_command_has_what_is_named(self):
        helps = {}
        for row in self.rows:
            for verb, flag in re.findall(r"`sightline ((?:scene )?\w+)(?: (--[\w-]+))?`", row[1]):
                if verb not in helps:
                    told = subprocess.run([COMMAND, *verb.split(), "--help"], capture_output=True, text=True, check=True)
                    helps[verb] = told.stdout
                with self.subTest(verb=verb, flag=flag):
                    self.assertIn(f"Usage: sightline {verb} ", helps[verb])
                    self.assertIn(flag, helps[verb])


class AioTest(unittest.TestCase):
    def test_aio_has_every_method_and_parameter(self):
        for name, original in OBJECTS.items():
            methods = inspect.getmembers(original, lambda member: callable(member) or isinstance(member, property))
            for method, function in methods:
                if method.startswith("_"):
                    continue
                with self.subTest(f"{name}.{method}"):
                    awaited = getattr(AWAITED[name], method)
                    if isinstance(function, property):
                        continue
                    parameters = inspect.signature(awaited).parameters
                    if not any(one.kind is one.VAR_KEYWORD for one in parameters.values()):
                        self.assertEqual(list(parameters), list(inspect.signature(function).parameters))


if __name__ == "__main__":
    unittest.main()
