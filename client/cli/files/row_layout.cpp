// The two layouts.
#include "client/cli/files/row_layout.h"

namespace sightline::client::cli::files {
namespace {

using Vector = std::pair<std::string_view, std::size_t>;

constexpr std::array<std::string_view, 8> kRayNames{"ox", "oy", "oz",   "dx",
                                                    "dy", "dz", "tmin", "tmax"};
constexpr std::array<std::size_t, 8> kRayColumns{0, 1, 2, 3, 4, 5, 6, 7};
constexpr std::array<Vector, 2> kRayVectors{{{"origin", 0}, {"direction", 3}}};
constexpr RowLayout kRays{"ray", "rays", kRayNames, kRayColumns, 6, kRayVectors};

constexpr std::array<std::string_view, 4> kPointNames{"x", "y", "z", "max"};
constexpr std::array<std::size_t, 4> kPointColumns{0, 1, 2, 7};
constexpr std::array<Vector, 1> kPointVectors{{{"position", 0}}};
constexpr RowLayout kPoints{"point", "points", kPointNames, kPointColumns, 3, kPointVectors};

}  // namespace

const RowLayout& layout_of(RowKind kind) { return kind == RowKind::kRays ? kRays : kPoints; }

}  // namespace sightline::client::cli::files
