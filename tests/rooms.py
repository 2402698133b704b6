#!/usr/bin/env python3
"""The tests of one room, which is a folder of tests: what has to be built for them, and which of ctest's tests they are.

CMake's file API says which sources a program has. A test of googletest's belongs to the folder of the file that defines it,
which the program itself tells; any other test to the folder whose CMakeLists.txt adds it.

  tests/rooms.py check ROOM            fails, and lists the rooms, where there is no such room
  tests/rooms.py ask BUILD             before CMake configures BUILD: has it write what the others read
  tests/rooms.py targets BUILD ROOM    prints what has to be built
"""

import collections
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TESTS = ROOT / "tests"
QUERY, REPLY = ".cmake/api/v1/query/codemodel-v2", ".cmake/api/v1/reply"


class UnknownRoom(Exception):
    """No test is in a folder of this name."""


def rooms():
    """All folders with tests in them or below them, as they are named from tests on."""
    found = set()
    for file in TESTS.rglob("*"):
        if file.name.endswith(("_test.cpp", "_test.py")) or \
                file.name == "CMakeLists.txt" and "add_test(" in file.read_text():
            for folder in file.relative_to(TESTS).parents:
                found.add(folder.as_posix())
    return sorted(found - {"."})


def named(room):
    """A room by its name, also written as a path of the checkout. Raises UnknownRoom."""
    name = room.strip("/").removeprefix("tests/")
    known = rooms()
    if name not in known:
        raise UnknownRoom(f"no tests are in a room {room!r}; there are\n  " + " ".join(known))
    return name


def ask_for_sources(build):
    """The next run of CMake in this build directory writes what Programs reads."""
    query = build / QUERY
    query.parent.mkdir(parents=True, exist_ok=True)
    query.touch()


# A target that is a program: its name, its path, the folder whose CMakeLists.txt makes it, and its sources.
Program = collections.namedtuple("Program", "name path folder sources")


def _programs(build):
    reply = build / REPLY
    index = json.loads(max(reply.glob("index-*.json")).read_text())
    model = json.loads((reply / index["reply"]["codemodel-v2"]["jsonFile"]).read_text())
    for entry in model["configurations"][0]["targets"]:
        target = json.loads((reply / entry["jsonFile"]).read_text())
        if target["type"] == "EXECUTABLE":
            yield Program(target["name"], build / target["artifacts"][0]["path"], ROOT / target["paths"]["source"],
                          [ROOT / source["path"] for source in target["sources"]])


def _is_in(path, room):
    return path.resolve().is_relative_to(TESTS / room)


def _shown(build, options=()):
    """All tests that ctest's options leave: numbers, commands, and the files that add them, but for googletest's."""
    shown = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", *options], check=True,
                                      capture_output=True, text=True).stdout)
    graph = shown["backtraceGraph"]
    for number, test in enumerate(shown["tests"], 1):
        node = graph["nodes"][test["backtrace"]] if "backtrace" in test else None
        yield number, test.get("command", []), node and pathlib.Path(graph["files"][node["file"]])


def targets(build, room):
    """What to build: the programs that have a test of the room among their sources, and what its other tests run."""
    programs = list(_programs(build))
    wanted = {program.name for program in programs if _has_test_in(program, room)}
    made = {str(program.path): program.name for program in programs} | {str(build / "client/python"): "sightline_python"}
    for _, command, added_by in _shown(build):
        if added_by is None or not _is_in(added_by, room):
            continue
        if str(build) in command:
            return ["all"]  # it is installed, or its programs are found by their names
        wanted.update(made[argument] for argument in command if argument in made)
        if not command:  # ctest does not name a program that is not there yet
            wanted.update(program.name for program in programs if program.folder == added_by.parent)
    return sorted(wanted)


def _has_test_in(program, room):
    return any(_is_in(source, room) and source.name.endswith("_test.cpp") for source in program.sources)


def _filter_of(command):
    return next((argument.removeprefix("--gtest_filter=") for argument in command
                 if argument.startswith("--gtest_filter=")), None)


def _tests_in(build, program, room):
    """Names, as a filter writes them, of a program's tests that files of the room define. A compiler that ccache calls may know files
    by paths from the build directory."""
    with tempfile.TemporaryDirectory() as folder:
        listed = pathlib.Path(folder) / "tests.json"
        subprocess.run([program, "--gtest_list_tests", f"--gtest_output=json:{listed}"], check=True, stdout=subprocess.DEVNULL)
        return {f"{suite['name']}.{test['name']}" for suite in json.loads(listed.read_text())["testsuites"]
                for test in suite["testsuite"] if _is_in(build / test["file"], room)}


def numbers(build, room, options=()):
    """The room's tests, in programs that are built: their numbers among those that ctest's options leave, as -I counts them."""
    names = {str(program.path): _tests_in(build, program.path, room) for program in _programs(build)
             if program.path.exists() and _has_test_in(program, room)}
    return [number for number, command, added_by in _shown(build, options)
            if (added_by is not None and _is_in(added_by, room)) or
            (command and _filter_of(command) in names.get(command[0], ()))]


def main():
    match sys.argv[1:]:
        case ["check", room]:
            named(room)
        case ["ask", build]:
            ask_for_sources(pathlib.Path(build))
        case ["targets", build, room]:
            print(*targets(pathlib.Path(build).resolve(), named(room)), sep="\n")
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    try:
        main()
    except UnknownRoom as unknown:
        print(f"tests/run: {unknown}", file=sys.stderr)
        sys.exit(2)
