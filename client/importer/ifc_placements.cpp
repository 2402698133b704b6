// Composes placements twice, in float32 as Assimp does, and in double.
#include "client/importer/ifc_placements.h"

#include <assimp/types.h>

#include <charconv>
#include <cstddef>
#include <string>

#include "client/importer/formats/text.h"

namespace sightline::client::importer {
namespace {

constexpr int kDeepestPlacement = 100;

using Matrix = aiMatrix4x4t<double>;
using Vector3 = aiVector3t<double>;

Vector3 vector_of(const Statement* statement, const Vector3& otherwise) {
  if (statement == nullptr) return otherwise;
  const auto numbers = numbers_of(argument(*statement, 0));
  return {numbers[0], numbers[1], numbers[2]};
}

// IFCAXIS2PLACEMENT3D
Matrix axes_of(const Statements& statements, const Statement& axes) {
  const Vector3 at = vector_of(statements.find(argument(axes, 0)), {0, 0, 0});
  Vector3 z = vector_of(statements.find(argument(axes, 1)), {0, 0, 1});
  Vector3 x = vector_of(statements.find(argument(axes, 2)), {1, 0, 0});
  z.NormalizeSafe();
  x -= z * (x * z);
  x.NormalizeSafe();
  const Vector3 y = z ^ x;
  return {x.x, y.x, z.x, at.x, x.y, y.y, z.y, at.y, x.z, y.z, z.z, at.z, 0, 0, 0, 1};
}

struct Placement {
  Matrix exact;
  aiMatrix4x4 rounded;
};

Placement placement_of(const Statements& statements, const Statement* placement, int depth) {
  if (placement == nullptr || placement->type != "IFCLOCALPLACEMENT" || depth == 0) return {};
  Placement out = placement_of(statements, statements.find(argument(*placement, 0)), depth - 1);
  const Statement* const axes = statements.find(argument(*placement, 1));
  if (axes == nullptr || axes->type != "IFCAXIS2PLACEMENT3D") return out;
  const Matrix step = axes_of(statements, *axes);
  out.exact *= step;
  out.rounded *= static_cast<aiMatrix4x4>(step);
  return out;
}

double loss_of(const Placement& placement) {
  const aiMatrix4x4& m = placement.rounded;
  const Vector3 rounded(static_cast<double>(m.a4), static_cast<double>(m.b4),
                        static_cast<double>(m.c4));
  return (Vector3(placement.exact.a4, placement.exact.b4, placement.exact.c4) - rounded).Length();
}

// The number in an argument like IFCLENGTHMEASURE(0.3048); 0: it is none.
double measure_of(std::string_view argument) {
  const std::size_t open = argument.find('(');
  if (open == argument.npos) return 0;
  const std::string_view number = formats::trimmed(argument.substr(open + 1));
  double value = 0;
  std::from_chars(number.data(), number.data() + number.size(), value);
  return value;
}

// IFCSIUNIT(*,.LENGTHUNIT.,prefix,.METRE.), or 0.
double meters_of(const Statement* unit) {
  if (unit == nullptr || unit->type != "IFCSIUNIT" || argument(*unit, 3) != ".METRE.") return 0;
  const std::string_view prefix = argument(*unit, 2);
  if (prefix == ".MILLI.") return 1e-3;
  if (prefix == ".CENTI.") return 1e-2;
  if (prefix == ".DECI.") return 1e-1;
  return prefix == "$" ? 1 : 0;
}

}  // namespace

std::unordered_map<std::string_view, double> ifc_losses(const Statements& statements) {
  std::unordered_map<std::string_view, double> losses;
  for (const auto& [number, statement] : statements.all()) {
    const std::string_view id = argument(statement, 0);
    if (id.size() < 3 || !id.starts_with('\'')) continue;
    const Statement* const placement = statements.find(argument(statement, 5));
    const double loss = loss_of(placement_of(statements, placement, kDeepestPlacement));
    if (loss > 0) losses[id.substr(1, id.size() - 2)] = loss;
  }
  return losses;
}

double ifc_meters_per_unit(const Statements& statements) {
  for (const auto& [number, statement] : statements.all()) {
    if (statement.type != "IFCUNITASSIGNMENT") continue;
    double meters = 1;
    statements.each_of(argument(statement, 0), [&](const Statement& unit) {
      if (unit.type != "IFCCONVERSIONBASEDUNIT" || argument(unit, 1) != ".LENGTHUNIT.") return true;
      const Statement* const measure = statements.find(argument(unit, 3));
      if (measure == nullptr) return true;
      meters =
          measure_of(argument(*measure, 0)) * meters_of(statements.find(argument(*measure, 1)));
      return true;
    });
    return meters > 0 ? meters : 0;
  }
  return 1;
}

}  // namespace sightline::client::importer
