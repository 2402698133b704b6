// Follows the statements of each product and of each face.
#include "client/importer/ifc_contents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::client::importer {
namespace {

constexpr int kDeepest = 16;  // mapped items in mapped items

bool is_solid_type(std::string_view type) {
  constexpr std::string_view kSolids[] = {
      "IFCEXTRUDEDAREASOLID", "IFCREVOLVEDAREASOLID",     "IFCSURFACECURVESWEPTAREASOLID",
      "IFCSWEPTDISKSOLID",    "IFCFACETEDBREP",           "IFCFACETEDBREPWITHVOIDS",
      "IFCBOOLEANRESULT",     "IFCBOOLEANCLIPPINGRESULT", "IFCCSGSOLID",
      "IFCCLOSEDSHELL"};
  return std::find(std::begin(kSolids), std::end(kSolids), type) != std::end(kSolids);
}

bool is_solid(const Statements& statements, const Statement& item, int depth) {
  if (is_solid_type(item.type)) return true;
  if (item.type == "IFCSHELLBASEDSURFACEMODEL") {
    return statements.each_of(argument(item, 0),
                              [](const Statement& shell) { return is_solid_type(shell.type); });
  }
  if (item.type != "IFCMAPPEDITEM" || depth == kDeepest) return false;
  const Statement* const map = statements.find(argument(item, 0));
  const Statement* const mapped = map ? statements.find(argument(*map, 1)) : nullptr;
  return mapped != nullptr && statements.each_of(argument(*mapped, 3), [&](const Statement& inner) {
    return is_solid(statements, inner, depth + 1);
  });
}

std::array<double, 3> point_of(const Statement& point) {
  return point.type == "IFCCARTESIANPOINT" ? numbers_of(argument(point, 0))
                                           : std::array<double, 3>{};
}

using Loop = std::vector<std::array<double, 3>>;

Loop loop_of(const Statements& statements, const Statement& loop) {
  Loop points;
  statements.each_of(argument(loop, 0), [&](const Statement& point) {
    points.push_back(point_of(point));
    return true;
  });
  return points;
}

// Twice the area that the loop of points goes around.
double double_area(const Loop& points) {
  std::array<double, 3> normal{};
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
      normal[k] += (points[i][u] - points[0][u]) * (points[i + 1][v] - points[0][v]) -
                   (points[i][v] - points[0][v]) * (points[i + 1][u] - points[0][u]);
    }
  }
  return std::hypot(normal[0], normal[1], normal[2]);
}

// Whether the face is a loop that Assimp 5.2 takes for one without area, though it has one, or has
// a hole that Assimp takes for one: it compares with numbers, whatever the unit is.
bool is_lost(const Statements& statements, const Statement& face) {
  constexpr double kLeastFace = 1e-5, kLeastHole = 3.2e-3, kNothing = 1e-12;  // twice the area
  double largest = 0, least = HUGE_VAL;
  std::size_t bounds = 0;
  const bool is_known = statements.each_of(argument(face, 0), [&](const Statement& bound) {
    const Statement* const loop = statements.find(argument(bound, 0));
    if (loop == nullptr || loop->type != "IFCPOLYLOOP") return false;
    const Loop points = loop_of(statements, *loop);
    double extent = 0;
    for (const auto& point : points) {
      for (std::size_t k = 0; k < 3; ++k)
        extent = std::max(extent, std::abs(point[k] - points[0][k]));
    }
    const double area = double_area(points);
    if (area <= kNothing * extent * extent) return true;
    ++bounds;
    largest = std::max(largest, area);
    least = std::min(least, area);
    return true;
  });
  return is_known && bounds > 0 && (largest < kLeastFace || (bounds > 1 && least < kLeastHole));
}

bool holds_faces(const Statement& statement) {
  return statement.type == "IFCCLOSEDSHELL" || statement.type == "IFCOPENSHELL" ||
         statement.type == "IFCCONNECTEDFACESET";
}

// How many corners of a shell Assimp 5.2 takes for the one before them, though they are not: those
// that are nearer than about 3e-5 of the shell's diagonal.
std::uint64_t count_merged(const Statements& statements, const Statement& shell) {
  std::vector<Loop> loops;
  statements.each_of(argument(shell, 0), [&](const Statement& face) {
    return statements.each_of(argument(face, 0), [&](const Statement& bound) {
      const Statement* const loop = statements.find(argument(bound, 0));
      if (loop != nullptr && loop->type == "IFCPOLYLOOP")
        loops.push_back(loop_of(statements, *loop));
      return true;
    });
  });
  const auto squared = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    const double length = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    return length * length;
  };
  std::array<double, 3> lo{HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const Loop& loop : loops) {
    for (const auto& point : loop) {
      for (std::size_t k = 0; k < 3; ++k)
        lo[k] = std::min(lo[k], point[k]), hi[k] = std::max(hi[k], point[k]);
    }
  }
  const double least = squared(lo, hi) / 1e9;
  std::uint64_t merged = 0;
  for (const Loop& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const double distance = squared(loop[i], loop[(i + 1) % loop.size()]);
      if (distance > 0 && distance < least) ++merged;
    }
  }
  return merged;
}

// Whether the representations named Body have solids alone, and there is one.
bool has_solid_body(const Statements& statements, const Statement& shape) {
  bool has_body = false;
  return statements.each_of(argument(shape, 2), [&](const Statement& representation) {
    if (argument(representation, 1) != "'Body'") return true;
    has_body = true;
    return statements.each_of(argument(representation, 3),
                              [&](const Statement& item) { return is_solid(statements, item, 0); });
  }) && has_body;
}

}  // namespace

IfcContents ifc_contents(const Statements& statements) {
  constexpr std::size_t kIdLength = 22;
  IfcContents out;
  const std::vector<std::uint64_t> loose = statements.loose_ends();
  out.loose_ends = loose.size();
  if (!loose.empty()) out.first_loose = *std::min_element(loose.begin(), loose.end());
  for (const auto& [number, statement] : statements.all()) {
    if (statement.type == "IFCFACE" && is_lost(statements, statement)) {
      if (out.lost_faces++ == 0 || number < out.first_lost) out.first_lost = number;
    }
    if (holds_faces(statement)) {
      const std::uint64_t merged = count_merged(statements, statement);
      if (merged > 0 && (out.merged_corners == 0 || number < out.first_merged))
        out.first_merged = number;
      out.merged_corners += merged;
    }
    const std::string_view id = argument(statement, 0);
    if (id.size() != kIdLength + 2 || !id.starts_with('\'')) continue;
    const Statement* const shape = statements.find(argument(statement, 6));
    if (shape == nullptr || shape->type != "IFCPRODUCTDEFINITIONSHAPE") continue;
    if (has_solid_body(statements, *shape)) out.solids.insert(id.substr(1, kIdLength));
  }
  return out;
}

}  // namespace sightline::client::importer
