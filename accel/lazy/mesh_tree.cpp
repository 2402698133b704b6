// Triangles under the kd-tree: making references of them, and testing them in its leaves.
#include "accel/lazy/mesh_tree.h"

#include <algorithm>

#include "accel/lazy/face_boxes.h"
#include "accel/lazy/runs.h"

namespace sightline::accel {
namespace {

/// Runs are opened by the rule of membership, which builders do not follow that choose the side of
/// flat boxes.
bool takes_runs(const AnyBuilder& builder) {
  return !std::holds_alternative<ExactBuilder>(builder);
}

/// A mesh's faces, or runs of them: decided by whoever asks first.
class Faces {
 public:
  Faces(const MeshView& mesh, const Aabb& bounds, bool may_run)
      : mesh_(mesh), bounds_(bounds), kind_(may_run ? Kind::kUnknown : Kind::kFaces) {}

  ReferenceSource::Coarsest coarsest(BuildCounters& counters) const {
    Kind kind = kind_.load(std::memory_order_relaxed);
    if (kind == Kind::kUnknown) {
      kind = are_runs_compact(mesh_, bounds_, counters) ? Kind::kRuns : Kind::kFaces;
      kind_.store(kind, std::memory_order_relaxed);
    }
    const bool runs = kind == Kind::kRuns;
    return {.places = runs ? count_runs(mesh_) : mesh_.faces.size(), .openable = runs};
  }

  std::size_t list(std::size_t begin, std::size_t end, BoxRef* out, BuildCounters& counters) const {
    if (coarsest(counters).openable) return run_references(mesh_, begin, end, out, counters);
    counters.touches_prepare += end - begin;
    return face_references(mesh_, begin, end, out);
  }

  void open(const BoxRef& run, std::vector<BoxRef>& out, BuildCounters& counters) const {
    open_run(mesh_, run, out, counters);
  }

 private:
  enum class Kind : std::uint8_t { kUnknown, kFaces, kRuns };

  MeshView mesh_;
  Aabb bounds_;
  mutable std::atomic<Kind> kind_;
};

ReferenceSource source_of_faces(const MeshView& mesh, const Aabb& bounds, bool may_run,
                                std::shared_ptr<const void> alive) {
  const auto faces = std::make_shared<const Faces>(mesh, bounds, may_run);
  return {
      .coarsest = [faces](BuildCounters& counters) { return faces->coarsest(counters); },
      .list = [faces](std::size_t begin, std::size_t end, BoxRef* out,
                      BuildCounters& counters) { return faces->list(begin, end, out, counters); },
      .open = [faces](const BoxRef& run, std::vector<BoxRef>& out,
                      BuildCounters& counters) { faces->open(run, out, counters); },
      .alive = std::move(alive)};
}

}  // namespace

/// What a walk asks at leaves and at cells that are not built.
struct MeshTree::Visit {
  const MeshView& mesh;
  LazyTree& lazy;
  MeshQuery& query;
  const TreeRay& ray;
  WalkCounters& walked;
  BuildCounters& built;

  double limit() const { return query.best_t / query.ray.unit + ray.slack; }

  bool test(std::uint32_t id) {
    ++walked.tests;
    const Face& f = mesh.faces[id];
    const Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]], &c = mesh.vertices[f[2]];
    const std::optional<double> local = intersect(query.ray, a, b, c);
    if (!local) return false;
    const double t = *local * query.ray.unit;
    if (!(t >= query.tmin && t <= query.tmax) || t > query.best_t) return false;
    if (is_culled(query.culling, query.ray, a, b, c)) return false;
    if (query.collects()) {
      collect(t, id);
      return false;
    }
    if (t == query.best_t) {
      if (query.node > query.best_node) return false;
      if (query.node == query.best_node && id >= query.best_primitive) return false;
    }
    query.best_t = t;
    query.best_node = query.node;
    query.best_primitive = id;
    query.best_instance = query.instance;
    query.found = true;
    return query.any;
  }

  void collect(double t, std::uint32_t id) {
    query.found = true;
    if (query.primitives != nullptr) {
      query.primitives->add(id);
    } else if (query.list->add({t, query.node, id, query.instance})) {
      if (const ListedHit* last = query.list->greatest()) query.best_t = last->t;
    }
  }

  bool leaf(std::span<const std::uint32_t> ids) {
    for (const std::uint32_t id : ids) {
      if (test(id)) return true;
    }
    return false;
  }

  Unbuilt unbuilt(AtomicSlot& slot, const DeferredCell& cell) {
    if (query.at_unbuilt == AtUnbuilt::kExpand) {
      const Expanded expanded = lazy.expand(slot, query.at_busy, built);
      if (expanded == Expanded::kAgain) return Unbuilt::kAgain;
      if (expanded == Expanded::kBusy) {
        query.put_aside = true;
        query.progress = LazyTree::progress(slot);
        return Unbuilt::kStop;
      }
    }
    query.met_unbuilt = true;
    if (query.at_unbuilt == AtUnbuilt::kSkip) return Unbuilt::kDone;
    return search(cell) ? Unbuilt::kStop : Unbuilt::kDone;
  }

  bool search(const DeferredCell& cell) {
    if (cell.listed)
      return cell.list.any_part([&](std::span<const BoxRef> refs) { return search(refs); });
    return search_faces({0, mesh.faces.size()});
  }

  bool search(std::span<const BoxRef> refs) {
    return std::any_of(refs.begin(), refs.end(), [&](const BoxRef& ref) {
      if (!may_meet(ray, ref.bounds(), limit())) return false;
      if (!ref.openable()) return test(ref.id);
      return search_faces(faces_of_run(mesh, ref));
    });
  }

  bool search_faces(FaceRange faces) {
    for (std::size_t i = faces.begin; i < faces.end; ++i) {
      const std::optional<Aabb> box = face_bounds(mesh, i);
      if (box && may_meet(ray, *box, limit()) && test(static_cast<std::uint32_t>(i))) return true;
    }
    return false;
  }
};

MeshTree::MeshTree(MeshView mesh, const MeshSurvey& survey, const AnyBuilder& builder,
                   References references, std::shared_ptr<const void> alive)
    : mesh_(mesh),
      lazy_(
          padded(survey.bounds), survey.finite_triangles, builder,
          source_of_faces(mesh, survey.bounds,
                          references == References::kRuns && takes_runs(builder), std::move(alive)),
          &mesh_) {}

void MeshTree::query(MeshQuery& query, WalkCounters& walked, BuildCounters& built) {
  TreeRay ray;
  const double tmax = std::min(query.tmax, query.best_t);
  if (!enter(query.ray, tree().bounds(), query.tmin / query.ray.unit, tmax / query.ray.unit, ray))
    return;
  Visit visit{mesh_, lazy_, query, ray, walked, built};
  walk(tree(), ray, lazy_.root(), walked, visit);
}

}  // namespace sightline::accel
