// Indexes the statements of the file by their numbers, and follows those of each product.
#include "client/importer/ifc_contents.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "client/importer/formats/text.h"

namespace sightline::client::importer {
namespace {

using formats::trimmed;

constexpr int kDeepest = 16;  // mapped items in mapped items

struct Statement {
  std::string_view type, arguments;
};

// Where `text` has this character outside of strings and, if `depth` is counted, of brackets.
std::size_t find_outside(std::string_view text, char wanted, bool counts_depth) {
  bool in_string = false;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\'') in_string = !in_string;
    if (in_string) continue;
    if (c == wanted && (depth == 0 || !counts_depth)) return i;
    if (c == '(') ++depth;
    if (c == ')') --depth;
  }
  return text.size();
}

// 0: no reference.
std::uint64_t number_of(std::string_view reference) {
  if (!reference.starts_with('#')) return 0;
  std::uint64_t number = 0;
  for (const char c : reference.substr(1)) {
    if (c < '0' || c > '9') break;
    number = 10 * number + static_cast<std::uint64_t>(c - '0');
  }
  return number;
}

std::string_view argument(const Statement& statement, std::size_t index) {
  std::string_view rest = statement.arguments;
  for (;; --index) {
    const std::size_t end = find_outside(rest, ',', true);
    if (index == 0) return trimmed(rest.substr(0, end));
    if (end == rest.size()) return {};
    rest.remove_prefix(end + 1);
  }
}

bool is_solid_type(std::string_view type) {
  constexpr std::string_view kSolids[] = {
      "IFCEXTRUDEDAREASOLID", "IFCREVOLVEDAREASOLID",     "IFCSURFACECURVESWEPTAREASOLID",
      "IFCSWEPTDISKSOLID",    "IFCFACETEDBREP",           "IFCFACETEDBREPWITHVOIDS",
      "IFCBOOLEANRESULT",     "IFCBOOLEANCLIPPINGRESULT", "IFCCSGSOLID",
      "IFCCLOSEDSHELL"};
  return std::find(std::begin(kSolids), std::end(kSolids), type) != std::end(kSolids);
}

class Statements {
 public:
  explicit Statements(std::string_view step) {
    while (!step.empty()) {
      const std::size_t end = find_outside(step, ';', false);
      add(trimmed(step.substr(0, end)));
      step.remove_prefix(std::min(step.size(), end + 1));
    }
  }

  const std::unordered_map<std::uint64_t, Statement>& all() const { return all_; }

  /// Numbers that two statements have, or that one names and none has.
  std::vector<std::uint64_t> loose_ends() const {
    std::vector<std::uint64_t> out = repeated_;
    for (const auto& [number, statement] : all_) {
      std::string_view rest = statement.arguments;
      for (std::size_t at = find_outside(rest, '#', false); at < rest.size();
           at = find_outside(rest, '#', false)) {
        rest.remove_prefix(at);
        const std::uint64_t named = number_of(rest);
        if (!all_.contains(named)) out.push_back(named);
        rest.remove_prefix(1);
      }
    }
    return out;
  }

  const Statement* find(std::string_view reference) const {
    const auto found = all_.find(number_of(reference));
    return found == all_.end() ? nullptr : &found->second;
  }

  /// Whether `is_met` is true for each statement of the list, and there is one.
  template <class IsMet>
  bool each_of(std::string_view list, const IsMet& is_met) const {
    if (!list.starts_with('(') || !list.ends_with(')')) return false;
    const Statement items{{}, list.substr(1, list.size() - 2)};
    for (std::size_t i = 0;; ++i) {
      const std::string_view item = argument(items, i);
      if (item.empty()) return i > 0;
      const Statement* const statement = find(item);
      if (statement == nullptr || !is_met(*statement)) return false;
    }
  }

 private:
  void add(std::string_view text) {
    const std::uint64_t number = number_of(text);
    const std::size_t equals = text.find('='), open = text.find('(');
    if (number == 0 || equals >= open || open == text.npos || !text.ends_with(')')) return;
    if (all_.contains(number)) repeated_.push_back(number);
    all_[number] = {trimmed(text.substr(equals + 1, open - equals - 1)),
                    text.substr(open + 1, text.size() - open - 2)};
  }

  std::unordered_map<std::uint64_t, Statement> all_;
  std::vector<std::uint64_t> repeated_;
};

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
  const std::string_view list = argument(point, 0);
  std::array<double, 3> out{};
  if (point.type != "IFCCARTESIANPOINT" || list.size() < 2) return out;
  const Statement numbers{{}, list.substr(1, list.size() - 2)};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string_view number = argument(numbers, k);
    std::from_chars(number.data(), number.data() + number.size(), out[k]);
  }
  return out;
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

IfcContents ifc_contents(std::string_view step) {
  constexpr std::size_t kIdLength = 22;
  const Statements statements(step);
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
