// Serves one prefetch.
#include "server/queries/prefetch_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/trace.h"
#include "server/queries/batch_rays.h"
#include "server/scenes/names.h"

namespace sightline::server::queries {
namespace {

/// The query of the rays or points. It has at most one root.
template <class Request>
Request query_of(const v1::PrefetchRequest& request) {
  Request query;
  query.set_scene(request.scene());
  query.set_kind(request.kind());
  query.set_build(v1::BUILD_MODE_LAZY);
  if (request.roots_size() == 1) query.set_root(request.roots(0));
  *query.mutable_exclude() = request.exclude();
  *query.mutable_only_labels() = request.only_labels();
  *query.mutable_exclude_labels() = request.exclude_labels();
  if (request.has_shard()) *query.mutable_shard() = request.shard();
  return query;
}

bool has_points(const v1::PrefetchRequest& request) {
  return request.has_points() || request.has_grid();
}

bool has_rays(const v1::PrefetchRequest& request) {
  return request.source_case() != v1::PrefetchRequest::SOURCE_NOT_SET;
}

std::uint64_t bytes_of_tree(const scenegraph::instances::SceneTree& tree) {
  const scenegraph::instances::Instances* instances = tree.instances_so_far();
  return instances != nullptr && instances->begun() ? instances->tree_bytes() : 0;
}

}  // namespace

Status PrefetchJob::open(const v1::PrefetchRequest& request) {
  if (Status good = scenes::check_scene_name(request.scene()); !good) return good;
  if (Status good = check_roots(request); !good) return good;
  auto query = has_points(request)
                   ? decode_query(query_of<v1::QueryPointsRequest>(request), services_.policy)
                   : decode_query(query_of<v1::CastRaysRequest>(request), services_.policy);
  if (!query) return query.error();
  if (Status good = check_shard(*query, services_); !good) return good;
  query_ = std::move(*query);
  roots_.assign(request.roots().begin(), request.roots().end());
  has_rays_ = has_rays(request);
  BatchRays rays;
  if (has_rays_) {
    if (Status good = rays.begin(request); !good) return good;
  }
  const auto scene = services_.find_loaded(request.scene());
  if (!scene) return scene.error();
  auto quota = services_.quotas.begin_work(caller_, rays.size(), request.ByteSizeLong());
  if (!quota) return quota.error();
  const std::size_t of_shards =
      is_sharded() ? std::min(rays.size(), kRaysOfPart) * shards::kShardedBytesPerRay : 0;
  auto ticket = services_.admission.admit(
      caller_, rays.size(),
      request.ByteSizeLong() + rays.size() * sizeof(accel::geometry::Ray) + of_shards);
  if (!ticket) return ticket.error();
  rays_.resize(rays.size());
  rays.decode(0, rays_);
  quota_ = std::move(*quota);
  ticket_ = std::move(*ticket);
  (*scene)->touch();
  snapshot_ = (*scene)->snapshot();
  revision_ = (*scene)->token(snapshot_->revision());
  if (is_sharded()) open_sharded(request);
  return {};
}

void PrefetchJob::open_sharded(const v1::PrefetchRequest& request) {
  if (!has_rays_) {
    asked_for_trees_ = request;
    return;
  }
  // Lists build what counts build.
  const shards::ShardedCast::Query query{.kind = query_.kind == scenegraph::QueryKind::kAll
                                                     ? scenegraph::QueryKind::kCount
                                                     : query_.kind};
  if (query_.points) {
    cast_ = std::make_unique<shards::ShardedCast>(services_.shard_peers, context_,
                                                  query_of<v1::QueryPointsRequest>(request), query);
  } else {
    cast_ = std::make_unique<shards::ShardedCast>(services_.shard_peers, context_,
                                                  query_of<v1::CastRaysRequest>(request), query);
  }
}

Status PrefetchJob::check_roots(const v1::PrefetchRequest& request) {
  const int limit = has_rays(request) ? 1 : kMaxPrefetchRoots;
  if (request.roots_size() <= limit) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("the request has {} roots, the limit is {}{}", request.roots_size(),
                           limit, has_rays(request) ? " where it has rays or points" : ""),
               "TOO_MANY_ROOTS"};
}

Status PrefetchJob::run() {
  Status done = has_rays_ ? grow() : build();
  services_.metrics.count_build(metrics::BuildReason::kPrefetch, progress_.meshes_done,
                                progress_.cells_expanded,
                                static_cast<double>(progress_.build_us) * 1e-6);
  return done;
}

Status PrefetchJob::build() {
  auto nodes = scenegraph::query::mesh_nodes_under(*snapshot_, roots_, query_.excluded);
  if (!nodes) return nodes.error();
  const auto shard = shard_of(query_, services_, snapshot_);
  if (!shard) return shard.error();
  const scenegraph::query::LabelView labels(*snapshot_, query_.labels);
  std::erase_if(*nodes, [&](const scenegraph::model::Node* node) {
    return !shard->has(node->id) || !labels.sees(node->id);
  });
  meshes_ = scenegraph::query::meshes_of(*nodes);
  known_.store(true, std::memory_order_release);
  if (Status built = scenegraph::query::build_mesh_trees(*nodes, progress_, &cancelled_); !built)
    return built;
  if (!roots_.empty()) return {};
  if (Status built = scenegraph::query::build_scene_tree(*snapshot_, progress_, &cancelled_);
      !built || query_.selects())
    return built;
  // Rays of all see all: they will find the instances flat.
  const auto all = scenegraph::build_all(*snapshot_, &cancelled_);
  if (!all) return all.error();
  progress_.add(all->cells_expanded, all->build_seconds);
  return {};
}

Status PrefetchJob::grow() {
  std::optional<scenegraph::query::Selection> selection;
  if (query_.selects()) {
    auto shard = shard_of(query_, services_, snapshot_);
    if (!shard) return shard.error();
    auto made = scenegraph::query::Selection::make(snapshot_, query_.root, query_.excluded,
                                                   query_.labels, *std::move(shard));
    if (!made) return made.error();
    selection.emplace(std::move(*made));
  }
  const scenegraph::TraceOptions options{.kind = query_.kind,
                                         .growth = query_.growth,
                                         .points = query_.points,
                                         .selection = selection ? &*selection : nullptr,
                                         .cancelled = &cancelled_};
  return scenegraph::grow_for_rays(*snapshot_, rays_, options, progress_);
}

void PrefetchJob::report(v1::PrefetchResponse& response) {
  encode_revision(revision_, *response.mutable_served());
  if (is_sharded() && !has_rays_) {
    trees_of_shards_.report(response);
  } else {
    report_own(response);
  }
  response.set_elapsed_us(static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begun_).count()));
}

void PrefetchJob::report_own(v1::PrefetchResponse& response) {
  response.set_meshes_done(progress_.meshes_done);
  response.set_meshes_total(progress_.meshes_total);
  std::uint64_t triangles = progress_.triangles_done;
  response.set_triangles_total(progress_.triangles_total);
  response.set_rays_done(progress_.rays_done);
  response.set_rays_total(rays_.size());
  response.set_cells_expanded(progress_.cells_expanded);
  response.set_build_us(progress_.build_us);
  if (!known_.load(std::memory_order_acquire)) return;
  // A mesh may be complete, and another begun, between the two readings.
  triangles = std::min<std::uint64_t>(triangles + scenegraph::query::triangles_begun(meshes_),
                                      progress_.triangles_total);
  triangles_reported_ = std::max(triangles_reported_, triangles);
  response.set_triangles_done(triangles_reported_);
  std::uint64_t bytes = 0;
  if (roots_.empty()) {
    for (const scenegraph::instances::Level& level : snapshot_->shared_trees().levels)
      bytes += bytes_of_tree(*level.tree);
  }
  for (const scenegraph::model::Mesh* mesh : meshes_) bytes += mesh->tree_bytes();
  response.set_bytes_trees(bytes);
}

void PrefetchJob::close() {
  quota_ = {};
  ticket_ = {};
  meshes_ = {};
  cut_.reset();
  snapshot_.reset();
}

}  // namespace sightline::server::queries
