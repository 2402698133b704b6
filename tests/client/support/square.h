// A scene for tests of the command.
#pragma once

namespace sightline::tests {

/// An .obj of the unit square in z = 0, two triangles and a line.
inline constexpr const char* kSquareObj =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no square\nf 1 2 3\nf 1 3 4\nl 1 2\n";

}  // namespace sightline::tests
