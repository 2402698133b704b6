// Reads animations and sequences of frames as motions.
#include "client/cli/playback/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "client/cli/terminal.h"
#include "client/importer/frame_sequence.h"

namespace sightline::client::cli::playback {
namespace {

void name_nodes(const importer::Pose& pose, Motion& motion) {
  for (const importer::Pose::Placed& placed : pose.placed) motion.placed.push_back(placed.node);
  for (const importer::Pose::Shaped& shaped : pose.shaped)
    motion.shaped.insert(motion.shaped.end(), shaped.nodes.begin(), shaped.nodes.end());
}

Result<Motion> open_sequence(const MotionRequest& request,
                             const importer::ImportProgress& progress) {
  auto read = import_sequence(request.path, request.frame, progress);
  if (!read) return read.error();
  const auto sequence = std::make_shared<const importer::FrameSequence>(*std::move(read));
  Motion motion;
  motion.scene = sequence->scene;
  motion.name = std::filesystem::path(request.path).filename().string();
  const std::size_t count = sequence->frames.size();
  motion.seconds = static_cast<double>(count) / request.fps;
  motion.is_cyclic = true;
  name_nodes(sequence->frames.front(), motion);
  if (motion.placed.empty() && motion.shaped.empty()) {
    return local_error(fmt::format("{}: its {} frames are all alike", request.path, count));
  }
  motion.pose = [sequence, fps = request.fps, count](double seconds) {
    // The time of a frame may be rounded to slightly less than its number.
    const double frame = std::floor(seconds * fps + 1e-6);
    return sequence->frames[std::min(static_cast<std::size_t>(std::max(frame, 0.0)), count - 1)];
  };
  return motion;
}

std::string list_of(const std::vector<importer::Animation>& animations) {
  std::string list;
  for (std::size_t i = 0; i < animations.size(); ++i) {
    list += fmt::format("{}{} '{}' ({:.3g} s)", i == 0 ? "" : ", ", i, animations[i].name,
                        animations[i].seconds);
  }
  return list;
}

Result<std::size_t> choose(const MotionRequest& request,
                           const std::vector<importer::Animation>& animations) {
  if (animations.empty()) return local_error(request.path + ": holds no animation");
  if (request.animation.empty()) return std::size_t{0};
  const auto named =
      std::find_if(animations.begin(), animations.end(),
                   [&](const importer::Animation& a) { return a.name == request.animation; });
  if (named != animations.end()) return static_cast<std::size_t>(named - animations.begin());
  std::size_t number = 0;
  const char* const last = request.animation.data() + request.animation.size();
  const auto [end, error] = std::from_chars(request.animation.data(), last, number);
  if (error == std::errc() && end == last && number < animations.size()) return number;
  return local_error(fmt::format("{}: has no animation '{}', only {}", request.path,
                                 request.animation, list_of(animations)));
}

Result<Motion> open_animation(const MotionRequest& request,
                              const importer::ImportProgress& progress) {
  auto read = import_animated_scene(request.path, request.frame, progress);
  if (!read) return read.error();
  const auto file = std::make_shared<const importer::AnimatedScene>(*std::move(read));
  const auto chosen = choose(request, file->animations);
  if (!chosen) return chosen.error();
  const importer::Animation& animation = file->animations[*chosen];
  Motion motion;
  motion.scene = file->scene;
  motion.name = animation.name;
  motion.seconds = animation.seconds;
  name_nodes(pose(*file, animation, 0), motion);
  motion.pose = [file, &animation](double seconds) { return pose(*file, animation, seconds); };
  return motion;
}

}  // namespace

std::vector<Mobility> Motion::mobilities() const {
  std::vector<Mobility> out(scene.nodes.size(), Mobility::kStatic);
  for (const std::uint32_t node : placed) out[node] = Mobility::kRigid;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint32_t parent = scene.nodes[i].parent;
    if (parent != importer::kNone && out[parent] == Mobility::kRigid) out[i] = Mobility::kRigid;
  }
  for (const std::uint32_t node : shaped) out[node] = Mobility::kDeforming;
  return out;
}

Result<Motion> open_motion(const MotionRequest& request, const importer::ImportProgress& progress) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(request.path, error);
  return is_folder ? open_sequence(request, progress) : open_animation(request, progress);
}

}  // namespace sightline::client::cli::playback
