// updates: what a batch of updates costs, by kind, over the size of the scene and of the batch.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

using scenegraph::model::Affine;
using scenegraph::model::NodeId;
using scenegraph::model::NodeRef;
using scenegraph::model::Update;

/// Children of a group in the layout "groups".
constexpr std::size_t kPerGroup = 1000;

Affine at(double x) { return {{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}; }

/// Meshes of one triangle under one top node, directly or in groups.
class UpdatedScene {
 public:
  UpdatedScene(std::size_t nodes, bool grouped)
      : mesh_(*scenegraph::model::Mesh::make({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}})) {
    const std::size_t group_count = grouped ? (nodes + kPerGroup - 1) / kPerGroup : 0;
    std::vector<Update> puts{put(-1, 0, false), put(-2, 0, false)};
    for (std::size_t g = 0; g < group_count; ++g) puts.push_back(put(-3 - ref(g), -1, false));
    for (std::size_t i = 0; i < nodes; ++i) {
      const NodeRef parent = grouped ? -3 - ref(i / kPerGroup) : NodeRef{-1};
      puts.push_back(put(-3 - ref(group_count + i), parent, true));
    }
    const auto applied = scene_.apply(puts);
    top = ref(applied->nodes[0]);
    other = ref(applied->nodes[1]);
    for (std::size_t g = 0; g < group_count; ++g) groups.push_back(ref(applied->nodes[2 + g]));
    for (std::size_t i = 0; i < nodes; ++i)
      leaves.push_back(ref(applied->nodes[2 + group_count + i]));
    if (!grouped) groups.push_back(top);
    // From now on, what changes is removed from the static tree.
    const std::vector<accel::geometry::Ray> ray{{{0.2, 0.2, 5}, {0, 0, -1}}};
    std::vector<accel::geometry::Hit> hit(1);
    static_cast<void>(scenegraph::trace(*scene_.snapshot(), ray, hit, {}));
  }

  Update put(NodeRef node, NodeRef parent, bool with_mesh) const {
    scenegraph::model::PutNode put;
    put.node = node;
    put.parent = parent;
    put.parent_from_local = at(static_cast<double>(std::abs(node)));
    if (with_mesh) put.mesh = mesh_;
    return put;
  }

  /// Seconds, or an error if the batch is refused or the scene has another number of nodes than it
  /// should.
  Result<double> apply(const std::vector<Update>& updates, std::ptrdiff_t more_nodes) {
    const std::size_t before = scene_.snapshot()->node_count();
    const auto begin = std::chrono::steady_clock::now();
    const auto applied = scene_.apply(updates);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    if (!applied.ok()) return applied.error();
    const std::size_t now = scene_.snapshot()->node_count();
    if (now != before + static_cast<std::size_t>(more_nodes)) {
      return Error{Code::kDataLoss,
                   fmt::format("a batch that adds {} nodes made {} of {}", more_nodes, now, before),
                   {}};
    }
    return seconds.count();
  }

  NodeRef top = 0, other = 0;
  std::vector<NodeRef> groups, leaves;

 private:
  static NodeRef ref(std::size_t i) { return static_cast<NodeRef>(i); }

  std::shared_ptr<const scenegraph::model::Mesh> mesh_;
  scenegraph::Scene scene_;
};

struct Kind {
  const char* name;
  /// A batch that names `items` nodes; `round` counts batches.
  std::function<std::vector<Update>(UpdatedScene&, std::size_t items, int round)> make;
  std::ptrdiff_t nodes_per_item = 0;
  bool many = true;  ///< Also in batches of many items.
};

/// Spread over the scene.
NodeRef leaf(const UpdatedScene& scene, std::size_t item, std::size_t items) {
  return scene.leaves[item * (scene.leaves.size() / items)];
}

std::vector<Update> move(const std::vector<NodeRef>& nodes, double x) {
  return {scenegraph::model::SetTransforms{nodes, std::vector<Affine>(nodes.size(), at(x))}};
}

std::vector<Update> for_each(std::size_t items, const std::function<Update(std::size_t)>& make) {
  std::vector<Update> updates;
  for (std::size_t i = 0; i < items; ++i) updates.push_back(make(i));
  return updates;
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds{
      {"put new nodes",
       [](UpdatedScene& s, std::size_t items, int) {
         return for_each(items, [&](std::size_t i) {
           return s.put(-1 - static_cast<NodeRef>(i), s.groups.front(), true);
         });
       },
       1},
      {"put known nodes again",
       [](UpdatedScene& s, std::size_t items, int) {
         return for_each(items, [&](std::size_t i) {
           const std::size_t index = i * (s.leaves.size() / items);
           const std::size_t group = s.groups.size() == 1 ? 0 : index / kPerGroup;
           return s.put(s.leaves[index], s.groups[group], true);
         });
       }},
      {"move nodes",
       [](UpdatedScene& s, std::size_t items, int round) {
         std::vector<NodeRef> nodes;
         for (std::size_t i = 0; i < items; ++i) nodes.push_back(leaf(s, i, items));
         return move(nodes, round);
       }},
      {"move the node above all",
       [](UpdatedScene& s, std::size_t, int round) { return move({s.top}, round); }, 0, false},
      {"re-parent nodes to and fro",
       [](UpdatedScene& s, std::size_t items, int) {
         auto updates = for_each(
             items, [&](std::size_t i) { return s.put(leaf(s, i, items), s.other, true); });
         const auto back = for_each(items, [&](std::size_t i) {
           return s.put(leaf(s, i, items), s.groups.front(), true);
         });
         updates.insert(updates.end(), back.begin(), back.end());
         return updates;
       }},
      {"re-parent a group to and fro",
       [](UpdatedScene& s, std::size_t items, int) {
         return for_each(2 * items, [&](std::size_t i) {
           return s.put(s.groups.back(), i % 2 == 0 ? s.other : (s.groups.size() == 1 ? 0 : s.top),
                        false);
         });
       }},
      {"patch one mesh of all",
       [](UpdatedScene& s, std::size_t items, int round) {
         std::vector<NodeRef> nodes;
         for (std::size_t i = 0; i < items; ++i) nodes.push_back(leaf(s, i, items));
         return std::vector<Update>{
             scenegraph::model::PatchVertices{nodes, 0, {{0, 0, static_cast<float>(round)}}}};
       },
       0, false},
      {"delete nodes",
       [](UpdatedScene& s, std::size_t items, int) {
         return for_each(items, [&](std::size_t) {
           const NodeRef gone = s.leaves.back();
           s.leaves.pop_back();
           return scenegraph::model::DeleteNode{gone};
         });
       },
       -1}};
  return kKinds;
}

Result<Row> measure(UpdatedScene& scene, const Kind& kind, std::size_t items, int repeat) {
  std::vector<double> us;
  std::size_t updates_in_batch = 0;
  for (int round = 0; round <= repeat; ++round) {  // the first is not counted
    const std::vector<Update> updates = kind.make(scene, items, round);
    updates_in_batch = updates.size();
    const auto seconds =
        scene.apply(updates, kind.nodes_per_item * static_cast<std::ptrdiff_t>(items));
    if (!seconds.ok()) return seconds.error();
    if (round > 0) us.push_back(*seconds * 1e6);
  }
  Row row;
  row["kind"] = kind.name;
  row["items"] = items;
  row["updates"] = updates_in_batch;
  set_times(row, "us", us);
  row["us_per_item"] = median(us) / static_cast<double>(items);
  return row;
}

}  // namespace

Result<std::vector<Row>> run_updates(const CommonOptions& common, const UpdatesOptions& options) {
  std::vector<Row> rows;
  for (const std::size_t nodes : options.nodes) {
    for (const bool grouped : {true, false}) {
      UpdatedScene scene(nodes, grouped);
      for (const Kind& kind : kinds()) {
        for (const std::size_t items : {std::size_t{1}, options.items}) {
          if (items > 1 && !kind.many) continue;
          // At least half of the scene is left when nodes are deleted.
          if (items * static_cast<std::size_t>(common.repeat + 1) > nodes / 2) continue;
          auto measured = measure(scene, kind, items, common.repeat);
          if (!measured.ok()) return measured.error();
          Row row;
          row["nodes"] = nodes;
          row["layout"] = grouped ? "groups" : "flat";
          row.update(*measured);
          rows.push_back(std::move(row));
        }
      }
    }
  }
  return rows;
}

}  // namespace sightline::bench
