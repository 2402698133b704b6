// References of faces, or of runs of faces.
#include "accel/mesh/face_references.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/mesh/face_boxes.h"
#include "accel/mesh/runs.h"

namespace sightline::accel::mesh {
namespace {

/// A mesh's faces or runs of them; the first call decides which.
class Faces {
 public:
  Faces(const geometry::MeshView& mesh, const geometry::Aabb& bounds, bool may_run)
      : mesh_(mesh), bounds_(bounds), kind_(may_run ? Kind::kUnknown : Kind::kFaces) {}

  lazy::ReferenceSource::Coarsest coarsest(kdtree::BuildCounters& counters) const {
    Kind kind = kind_.load(std::memory_order_relaxed);
    if (kind == Kind::kUnknown) {
      kind = are_runs_compact(mesh_, bounds_, counters) ? Kind::kRuns : Kind::kFaces;
      kind_.store(kind, std::memory_order_relaxed);
    }
    const bool runs = kind == Kind::kRuns;
    return {.slots = runs ? count_runs(mesh_) : mesh_.faces.size(), .openable = runs};
  }

  std::size_t list(std::size_t begin, std::size_t end, kdtree::Reference* out,
                   kdtree::BuildCounters& counters) const {
    if (coarsest(counters).openable) return run_references(mesh_, begin, end, out, counters);
    counters.touches_prepare += end - begin;
    return face_references(mesh_, begin, end, out);
  }

  /// Remakes references from ids, by ranges of consecutive faces.
  void again(std::span<const std::uint32_t> ids, kdtree::Reference* out,
             kdtree::BuildCounters& counters) const {
    counters.touches_prepare += ids.size();
    for (std::size_t i = 0; i < ids.size();) {
      std::size_t end = i + 1;
      while (end < ids.size() && ids[end] == ids[end - 1] + 1) ++end;
      out += face_references(mesh_, ids[i], std::size_t{ids[end - 1]} + 1, out);
      i = end;
    }
  }

  void open(const kdtree::Reference& run, std::vector<kdtree::Reference>& out,
            kdtree::BuildCounters& counters) const {
    open_run(mesh_, run, out, counters);
  }

 private:
  enum class Kind : std::uint8_t { kUnknown, kFaces, kRuns };

  geometry::MeshView mesh_;
  geometry::Aabb bounds_;
  mutable std::atomic<Kind> kind_;
};

}  // namespace

lazy::ReferenceSource source_of_faces(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                                      bool may_run, std::shared_ptr<const void> alive) {
  const auto faces = std::make_shared<const Faces>(mesh, bounds, may_run);
  return {
      .coarsest = [faces](kdtree::BuildCounters& counters) { return faces->coarsest(counters); },
      .list =
          [faces](std::size_t begin, std::size_t end, kdtree::Reference* out,
                  kdtree::BuildCounters& counters) {
            return faces->list(begin, end, out, counters);
          },
      .open = [faces](const kdtree::Reference& run, std::vector<kdtree::Reference>& out,
                      kdtree::BuildCounters& counters) { faces->open(run, out, counters); },
      .again = [faces](std::span<const std::uint32_t> ids, kdtree::Reference* out,
                       kdtree::BuildCounters& counters) { faces->again(ids, out, counters); },
      .alive = std::move(alive)};
}

}  // namespace sightline::accel::mesh
