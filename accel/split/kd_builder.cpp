// Which builder is asked.
#include "accel/split/kd_builder.h"

namespace sightline::accel::split {

std::optional<kdtree::Cut> choose_cut(const KdBuilder& builder, const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) {
  return std::visit([&](const auto& b) { return b.choose(cell, counters); }, builder);
}

bool clips(const KdBuilder& builder, const kdtree::CellPath& path, std::size_t straddlers,
           std::size_t references) {
  return std::visit(
      [&](const auto& b) { return clips_straddlers(b, path, straddlers, references); }, builder);
}

bool runs_passes(const KdBuilder& builder) { return std::holds_alternative<ScanBuilder>(builder); }

bool scans_children(const KdBuilder& builder, std::size_t references) {
  const auto* scan = std::get_if<ScanBuilder>(&builder);
  return scan != nullptr && scan->scans_children(references);
}

FirstPlanes first_planes(const KdBuilder& builder, const geometry::Aabb& child) {
  return std::get<ScanBuilder>(builder).first_planes(child);
}

}  // namespace sightline::accel::split
