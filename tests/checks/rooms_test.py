"""tests/run ROOM leaves out no test: those of the folders in tests are all tests of the build, each once.

rooms_test.py TESTS    TESTS: the CTestTestfile.cmake of a build, of which programs may be missing
"""

import pathlib
import re
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import rooms

BUILD = pathlib.Path(sys.argv.pop(1)).resolve().parent


class Rooms(unittest.TestCase):
    def test_a_room_has_one_name_however_it_is_written(self):
        for written in ("accel/lazy", "accel/lazy/", "tests/accel/lazy", "tests/accel/lazy/"):
            self.assertEqual(rooms.named(written), "accel/lazy")

    def test_another_name_is_refused_with_those_that_there_are(self):
        for written in ("accel/nothing", "acc", "", ".", "..", "support/../accel"):
            with self.assertRaises(rooms.UnknownRoom) as refused:
                rooms.named(written)
            self.assertIn(" accel/lazy ", str(refused.exception))

    def test_what_a_room_needs_is_a_part_of_what_the_rooms_above_it_need(self):
        for room in ("accel/lazy", "accel/stability", "fuzz/verdict"):
            self.assertLessEqual(set(rooms.targets(BUILD, room)), set(rooms.targets(BUILD, room.split("/")[0])), room)
        self.assertEqual(rooms.targets(BUILD, "checks"), [])

    def test_each_test_is_in_one_room(self):
        shown = subprocess.run(["ctest", "--test-dir", BUILD, "--show-only"], check=True, capture_output=True, text=True).stdout
        there = [int(number) for number, name in re.findall(r"^ +Test +#(\d+): (\S+)", shown, re.MULTILINE)
                 if not name.endswith("_NOT_BUILT")]
        found = sorted(number for room in rooms.rooms() if "/" not in room for number in rooms.numbers(BUILD, room))
        self.assertEqual(found, there)
        fast = rooms.numbers(BUILD, "accel", ["-LE", "slow"])
        self.assertEqual(fast, list(range(fast[0], fast[0] + len(fast))), "one after another, as they are added")
        for room in ("accel/lazy", "fuzz/verdict"):
            inside, all_of_it = (set(rooms.numbers(BUILD, name)) for name in (room, room.split("/")[0]))
            self.assertLessEqual(inside, all_of_it, room)


if __name__ == "__main__":
    if not list((BUILD / rooms.REPLY).glob("index-*.json")):
        print("skipped: tests/run has not configured this build")
        sys.exit(77)
    unittest.main()
