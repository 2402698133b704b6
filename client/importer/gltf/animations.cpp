// A track for each channel; what a node's channels leave out is held at rest.
#include "client/importer/gltf/animations.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sightline::client::importer::gltf {
namespace {

constexpr const char* kPaths[] = {"translation", "rotation", "scale", "weights"};

Quaternion quaternion(const std::array<double, 4>& xyzw) {
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

Interpolation interpolation_of(const Item& sampler) {
  const std::string name = sampler.text("interpolation");
  if (name.empty() || name == "LINEAR") return Interpolation::kLinear;
  if (name == "STEP") return Interpolation::kStep;
  if (name == "CUBICSPLINE") return Interpolation::kCubic;
  refuse("{}: interpolation is '{}', must be LINEAR, STEP or CUBICSPLINE", sampler.where(),
         name.substr(0, 40));
}

class AnimationReader {
 public:
  AnimationReader(const Document& document, Accessors& accessors, const Meshes& meshes,
                  const Nodes& nodes, std::vector<Warning>& warnings)
      : document_(document),
        accessors_(accessors),
        meshes_(meshes),
        nodes_(nodes),
        warnings_(warnings) {}

  Animation read(const Item& item) {
    Animation out;
    out.name = item.text("name");
    targets_.clear();
    channel_of_node_.clear();
    const std::vector<Item> samplers = item.objects("samplers");
    for (const Item& channel : item.objects("channels")) {
      const std::uint64_t sampler = channel.integer("sampler");
      if (sampler >= samplers.size()) {
        refuse("{} names sampler {}, but there are {}", channel.where(), sampler, samplers.size());
      }
      const auto target = channel.object("target");
      if (!target) refuse("{}: target is missing", channel.where());
      read_channel(*target, samplers[sampler], out);
    }
    return out;
  }

 private:
  void read_channel(const Item& target, const Item& sampler, Animation& out) {
    const std::string path = target.text("path");
    const bool is_known = std::find(std::begin(kPaths), std::end(kPaths), path) != std::end(kPaths);
    if (!is_known) {
      warn("animation_target", target,
           fmt::format("animates '{}', which is not played", path.substr(0, 40)));
      return;
    }
    if (!target.has("node")) return;
    const std::uint64_t gltf = target.integer("node");
    const Item node = document_.at("nodes", gltf, target.where());
    if (nodes_.from_gltf[gltf] == kNone) return;
    if (path == "weights") {
      warn_if_again(target, gltf, path);
      read_weights(node, gltf, sampler, out);
      return;
    }
    const LocalTransform rest = local_transform(node);
    if (rest.has_matrix) {
      warn("animated_matrix", target,
           fmt::format("animates {}, which has a matrix; glTF forbids that, and it is not played",
                       node.where()));
      return;
    }
    warn_if_again(target, gltf, path);
    NodeChannel& channel = channel_of(nodes_.from_gltf[gltf], rest, out);
    if (path == "translation") channel.positions = points(sampler, out);
    if (path == "scale") channel.scalings = points(sampler, out);
    if (path == "rotation") channel.rotations = rotations(sampler, out);
  }

  void warn_if_again(const Item& target, std::uint64_t node, const std::string& path) {
    if (targets_.emplace(node, path).second) return;
    warn(
        "animated_twice", target,
        fmt::format("animates the {} of nodes[{}] once more; glTF forbids that, and one of the two "
                    "is played",
                    path, node));
  }

  NodeChannel& channel_of(std::uint32_t node, const LocalTransform& rest, Animation& out) {
    const auto [known, is_new] = channel_of_node_.emplace(node, out.channels.size());
    if (!is_new) return out.channels[known->second];
    NodeChannel channel;
    channel.node = node;
    channel.positions.keys = {{0, rest.translation}};
    channel.rotations.keys = {{0, rest.rotation}};
    channel.scalings.keys = {{0, rest.scale}};
    return out.channels.emplace_back(std::move(channel));
  }

  std::vector<std::array<double, 1>> times(const Item& sampler, Animation& out) {
    auto times = accessors_.rows<1>(sampler.integer("input"), sampler.where());
    if (times.empty()) refuse("{}: it has no keys", sampler.where());
    for (const auto& time : times) out.seconds = std::max(out.seconds, time[0]);
    return times;
  }

  // `value_at(i)` is the i-th value of `count`.
  template <class Value, class ValueAt>
  static Track<Value> track(const Item& sampler, const std::vector<std::array<double, 1>>& times,
                            std::size_t count, const ValueAt& value_at) {
    Track<Value> track;
    track.interpolation = interpolation_of(sampler);
    const bool is_cubic = track.interpolation == Interpolation::kCubic;
    const std::size_t per_key = is_cubic ? 3 : 1;
    if (count != per_key * times.size()) {
      refuse("{}: {} keys need {} values, but there are {}", sampler.where(), times.size(),
             per_key * times.size(), count);
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
      track.keys.push_back({times[i][0], value_at(is_cubic ? 3 * i + 1 : i)});
      if (is_cubic) track.tangents.push_back({value_at(3 * i), value_at(3 * i + 2)});
    }
    return track;
  }

  Track<Point> points(const Item& sampler, Animation& out) {
    const auto rows = accessors_.rows<3>(sampler.integer("output"), sampler.where());
    return track<Point>(sampler, times(sampler, out), rows.size(),
                        [&](std::size_t i) { return rows[i]; });
  }

  Track<Quaternion> rotations(const Item& sampler, Animation& out) {
    const auto rows = accessors_.rows<4>(sampler.integer("output"), sampler.where());
    const bool is_cubic = interpolation_of(sampler) == Interpolation::kCubic;
    return track<Quaternion>(sampler, times(sampler, out), rows.size(), [&](std::size_t i) {
      return is_cubic ? quaternion(rows[i]) : rotation_of(rows[i]);
    });
  }

  void read_weights(const Item& node, std::uint64_t gltf, const Item& sampler, Animation& out) {
    const std::size_t shapes = meshes_.shapes(node);
    if (shapes == 0) return;
    const auto rows = accessors_.rows<1>(sampler.integer("output"), sampler.where());
    if (rows.size() % shapes != 0) {
      refuse("{}: {} weights are none for all of {} targets", sampler.where(), rows.size(), shapes);
    }
    const auto weights_at = [&](std::size_t i) {
      std::vector<double> weights;
      for (std::size_t s = 0; s < shapes; ++s) weights.push_back(rows[i * shapes + s][0]);
      return weights;
    };
    const auto weights =
        track<std::vector<double>>(sampler, times(sampler, out), rows.size() / shapes, weights_at);
    for (const Nodes::MeshNodes& mesh_nodes : nodes_.mesh_nodes) {
      for (std::uint32_t i = 0; mesh_nodes.gltf == gltf && i < mesh_nodes.count; ++i)
        out.deformations.push_back({mesh_nodes.first + i, kNone, weights});
    }
  }

  void warn(const char* kind, const Item& where, const std::string& message) {
    const auto known = std::find_if(warnings_.begin(), warnings_.end(),
                                    [&](const Warning& warning) { return warning.kind == kind; });
    if (known != warnings_.end()) {
      ++known->count;
      return;
    }
    warnings_.push_back({.kind = kind,
                         .first = where.where(),
                         .message = fmt::format("{} {}", where.where(), message)});
  }

  const Document& document_;
  Accessors& accessors_;
  const Meshes& meshes_;
  const Nodes& nodes_;
  std::vector<Warning>& warnings_;
  // Both belong to the animation that is read.
  std::set<std::pair<std::uint64_t, std::string>> targets_;
  std::unordered_map<std::uint32_t, std::size_t> channel_of_node_;  // in its list of channels
};

}  // namespace

void read_animations(const Document& document, Accessors& accessors, const Meshes& meshes,
                     const Nodes& nodes, FileScene& scene) {
  AnimationReader reader(document, accessors, meshes, nodes, scene.warnings);
  for (std::size_t i = 0; i < document.count("animations"); ++i)
    scene.animations.push_back(reader.read(document.at("animations", i, "the file")));
}

}  // namespace sightline::client::importer::gltf
