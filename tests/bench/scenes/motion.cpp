// Frames from a directory of meshes, or of a swarm.
#include "tests/bench/scenes/motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tests/bench/scenes/generate_swarm.h"
#include "tests/bench/scenes/load_scene.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using scenegraph::model::Mobility;

namespace {

constexpr std::size_t kFramesAhead = 5;  // Each copy is this many frames ahead of the copy before
constexpr double kCopySpacing = 1.2;     // Distance between copies, in widths of the frames' box

Result<std::vector<std::string>> files_of(const std::string& directory) {
  std::vector<std::string> files;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(directory, failed)) {
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  }
  if (failed || files.empty()) {
    return Error{Code::kNotFound, fmt::format("no frames in \"{}\"", directory), "FRAMES"};
  }
  std::sort(files.begin(), files.end());
  return files;
}

void grow(scenegraph::model::DoubleBox& box, const Affine& world_from_local,
          const std::vector<Vec3f>& vertices) {
  for (const Vec3f& v : vertices) {
    if (is_finite(v)) box.grow(world_from_local.point(Vec3d(v)));
  }
}

}  // namespace

Result<Motion> Motion::make(const std::string& frames, std::size_t copies) {
  if (!frames.starts_with("gen:")) return load(frames, copies);
  if (copies != 1) {
    return Error{Code::kInvalidArgument, "--copies is for a directory of frames", "COMMAND_LINE"};
  }
  return swarm(frames);
}

Result<Motion> Motion::load(const std::string& directory, std::size_t copies) {
  const auto files = files_of(directory);
  if (!files.ok()) return files.error();
  Motion motion;
  SourceMesh first;
  for (const std::string& file : *files) {
    auto frame = load_scene(file);
    if (!frame.ok()) return frame.error();
    if (frame->meshes.size() != 1) {
      return Error{Code::kInvalidArgument,
                   fmt::format("{} holds {} meshes; a frame is one", file, frame->meshes.size()),
                   "FRAMES"};
    }
    SourceMesh& mesh = frame->meshes.front();
    if (motion.shapes_.empty()) {
      first = mesh;
    } else if (mesh.faces != first.faces || mesh.vertices.size() != first.vertices.size()) {
      return Error{Code::kInvalidArgument,
                   fmt::format("{} has not the topology of {}", file, files->front()), "FRAMES"};
    }
    motion.shapes_.push_back(std::move(mesh.vertices));
  }
  motion.frames_ = motion.shapes_.size();
  scenegraph::model::DoubleBox one;
  for (const auto& shape : motion.shapes_) grow(one, {}, shape);
  const Vec3d step = (one.hi - one.lo) * kCopySpacing;
  const auto row = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(copies))));
  for (std::size_t copy = 0; copy < copies; ++copy) {
    SourceMesh mesh{motion.shapes_[motion.shape(copy, 0)], first.faces};
    const std::size_t number = motion.parts_.add_mesh(std::move(mesh));
    const auto at = [&](std::size_t k) { return static_cast<double>(k); };
    motion.parts_.add_node(std::nullopt, fmt::format("copy {}", copy),
                           translation(at(copy % row) * step.x, 0, at(copy / row) * step.z),
                           number);
    motion.parts_.nodes.back().mobility = Mobility::kDeforming;
  }
  motion.measure();
  return motion;
}

Result<Motion> Motion::swarm(const std::string& generator) {
  auto parts = load_scene(generator);
  if (!parts.ok()) return parts.error();
  Motion motion;
  motion.parts_ = std::move(parts).value();
  motion.frames_ = kSwarmFrames;
  for (SourceNode& node : motion.parts_.nodes) {
    if (node.parent || !node.mesh) {
      return Error{Code::kInvalidArgument,
                   fmt::format("{} does not move; gen:swarm does", generator), "FRAMES"};
    }
    node.mobility = Mobility::kRigid;
  }
  for (std::size_t frame = 0; frame < kSwarmFrames; ++frame)
    motion.transforms_.push_back(swarm_transforms(motion.nodes(), frame));
  motion.measure();
  return motion;
}

std::size_t Motion::shape(std::size_t node, std::size_t frame) const {
  return (frame + kFramesAhead * node) % frames_;
}

const Affine& Motion::transform(std::size_t node, std::size_t frame) const {
  return rigid() ? transforms_[frame % frames_][node] : parts_.nodes[node].parent_from_local;
}

const std::vector<Vec3f>& Motion::vertices(std::size_t node, std::size_t frame) const {
  return rigid() ? parts_.meshes[*parts_.nodes[node].mesh].vertices : shapes_[shape(node, frame)];
}

void Motion::measure() {
  for (std::size_t frame = 0; frame < frames_; ++frame) {
    for (std::size_t n = 0; n < nodes(); ++n)
      grow(bounds_, transform(n, frame), vertices(n, frame));
  }
}

std::vector<scenegraph::model::Update> Motion::updates(std::size_t frame,
                                                       scenegraph::model::NodeId first) const {
  const auto ref = [&](std::size_t node) {
    return static_cast<scenegraph::model::NodeRef>(first + node);
  };
  std::vector<scenegraph::model::Update> updates;
  if (rigid()) {
    scenegraph::model::SetTransforms set;
    for (std::size_t n = 0; n < nodes(); ++n) set.nodes.push_back(ref(n));
    set.parent_from_local = transforms_[frame % frames_];
    updates.emplace_back(std::move(set));
    return updates;
  }
  for (std::size_t n = 0; n < nodes(); ++n)
    updates.emplace_back(scenegraph::model::PatchVertices{{ref(n)}, 0, vertices(n, frame)});
  return updates;
}

void Motion::pose(SceneSource& scene, std::size_t first_node, std::size_t frame) const {
  for (std::size_t n = 0; n < nodes(); ++n) {
    SourceNode& node = scene.nodes[first_node + n];
    node.parent_from_local = transform(n, frame);
    if (!rigid()) scene.meshes[*node.mesh].vertices = vertices(n, frame);
  }
}

}  // namespace sightline::bench
