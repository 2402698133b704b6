// Triangles under the kd-tree: making references of them, and testing them in its leaves.
#include "accel/lazy/mesh_tree.h"

#include <algorithm>

namespace sightline::accel {
namespace {

std::size_t run_end(const MeshView& mesh, std::size_t first_face) {
  return std::min(first_face + Runs::kRunLength, mesh.faces.size());
}

/// Runs, opened into runs and faces.
ReferenceSource source_of_runs(const MeshView& mesh, std::shared_ptr<const Runs> runs,
                               std::shared_ptr<const void> alive) {
  ReferenceSource source = source_of(runs->coarsest());
  source.list = [runs, list = source.list, faces = mesh.faces.size()](
                    std::size_t begin, std::size_t end, BoxRef* out, BuildCounters& counters) {
    if (begin == 0) counters.touches_prepare += faces;
    BuildCounters copied;
    return list(begin, end, out, copied);
  };
  source.open = [runs, mesh](const BoxRef& run, std::vector<BoxRef>& out) {
    if (const std::optional<std::size_t> first = Runs::first_face(run)) {
      const std::size_t before = out.size();
      out.resize(before + Runs::kRunLength);
      out.resize(before + face_references(mesh, *first, run_end(mesh, *first), &out[before]));
      return;
    }
    const std::span<const BoxRef> finer = runs->finer(run);
    out.insert(out.end(), finer.begin(), finer.end());
  };
  source.alive = std::move(alive);
  return source;
}

/// Runs are opened by the rule of membership, which builders do not follow that choose the side of
/// flat boxes.
bool takes_runs(const AnyBuilder& builder) {
  return !std::holds_alternative<ExactBuilder>(builder);
}

/// Every face on its own.
ReferenceSource source_of_faces(const MeshView& mesh, std::shared_ptr<const void> alive) {
  ReferenceSource source;
  source.count = mesh.faces.size();
  source.list = [mesh](std::size_t begin, std::size_t end, BoxRef* out, BuildCounters& counters) {
    counters.touches_prepare += end - begin;
    return face_references(mesh, begin, end, out);
  };
  source.alive = std::move(alive);
  return source;
}

}  // namespace

/// What a walk asks at leaves and at cells that are not built.
struct MeshTree::Visit {
  const MeshView& mesh;
  const Runs& runs;
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
    return runs.empty() ? search_faces(0, mesh.faces.size()) : search(runs.coarsest());
  }

  bool search(std::span<const BoxRef> refs) {
    return std::any_of(refs.begin(), refs.end(), [&](const BoxRef& ref) {
      if (ref.weight == 0 || !may_meet(ray, ref.bounds(), limit())) return false;
      if (!ref.openable()) return test(ref.id);
      if (const std::optional<std::size_t> first = Runs::first_face(ref))
        return search_faces(*first, run_end(mesh, *first));
      return search(runs.finer(ref));
    });
  }

  bool search_faces(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::optional<Aabb> box = face_bounds(mesh, i);
      if (box && may_meet(ray, *box, limit()) && test(static_cast<std::uint32_t>(i))) return true;
    }
    return false;
  }
};

MeshTree::MeshTree(MeshView mesh, MeshSurvey survey, const AnyBuilder& builder,
                   std::shared_ptr<const void> alive)
    : mesh_(mesh),
      runs_(std::make_shared<const Runs>(takes_runs(builder) ? std::move(survey.runs) : Runs())),
      lazy_(survey.bounds, survey.finite_triangles, builder,
            runs_->empty() ? source_of_faces(mesh, std::move(alive))
                           : source_of_runs(mesh, runs_, std::move(alive)),
            &mesh_) {}

void MeshTree::query(MeshQuery& query, WalkCounters& walked, BuildCounters& built) {
  TreeRay ray;
  const double tmax = std::min(query.tmax, query.best_t);
  if (!enter(query.ray, tree().bounds(), query.tmin / query.ray.unit, tmax / query.ray.unit, ray))
    return;
  Visit visit{mesh_, *runs_, lazy_, query, ray, walked, built};
  walk(tree(), ray, lazy_.root(), walked, visit);
}

}  // namespace sightline::accel
