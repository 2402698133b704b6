// Generated scenes: the same triangles on every machine, computed in double, then float meshes
// under double transforms.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// Loads the file that a generator's `mesh=` names.
using SceneLoader = std::function<Result<SceneSource>(const std::string& scene)>;

/// `spec` is the part of "gen:NAME?key=value&..." after "gen:". Errors: kInvalidArgument: no such
/// generator or key (the message lists them), a value that is not a number or is out of range; the
/// loader's errors.
Result<SceneSource> generate(std::string_view spec, const SceneLoader& load);

/// One line a generator: name, keys, ranges, defaults.
std::string list_generators();

// The generators. generate() checks the counts.

/// Value noise over a square of unit cells around the origin, y up, exactly `triangles` faces, row
/// by row.
SceneSource make_terrain(std::uint64_t triangles);
/// The same lattice, flat at y = 0.
SceneSource make_grid(std::uint64_t triangles);
/// Houses of 12 triangles, 50 to an object (a node with a mesh), y up. Sixteen objects form a
/// district (a group), sixteen districts a borough, and so on up to the city. An object has the
/// same position in every larger city.
SceneSource make_city(std::uint64_t boxes, std::uint64_t seed);
/// The same hierarchy, where each house is a node with its own mesh.
SceneSource make_village(std::uint64_t houses, std::uint64_t seed = 2006);
inline constexpr std::uint64_t kTrianglesPerHouse = 16;
/// A stand of seats around a pitch, and a ball of 81,920 triangles, 0.3 units wide, at its center.
SceneSource make_stadium();
/// Needles of 1 by 1e-4 in the unit cube, in random directions.
SceneSource make_slivers(std::uint64_t triangles, std::uint64_t seed);
/// 20 * 4^level triangles on the unit sphere; the node is moved by `offset` along each axis.
SceneSource make_icosphere(int level, double offset);
/// Instances of an icosphere, rotated, sheared, scaled along axes by 1/8 to 8, and half of them
/// mirrored, on a grid that is moved by `offset` along each axis.
SceneSource make_spheres(std::uint64_t copies, int level, double offset, std::uint64_t seed);
/// An axis-aligned wall in the unit cube, at x = `at`, with the `share` of the triangles, among
/// small triangles that are denser toward the middle of x.
SceneSource make_wall(std::uint64_t triangles, double share, double at, std::uint64_t seed);
/// Puts the faces of every mesh in random order.
SceneSource make_shuffled(SceneSource scene, std::uint64_t seed);
/// Copies (not instances) of all meshes of a scene, rotated about y, on a square grid.
SceneSource make_herd(const SceneSource& animal, std::uint64_t copies, std::uint64_t seed);
/// The scene inside a closed box of 12 triangles, half as large again.
SceneSource make_boxed(SceneSource scene);

}  // namespace sightline::bench
