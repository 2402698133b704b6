// Reads frames one after another and compares them with the first.
#include "client/importer/frame_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <optional>
#include <utility>

#include "client/importer/extension.h"
#include "client/importer/unread_formats.h"
namespace sightline::client::importer {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Removes the digits at the front of `text`, and returns them without leading zeros.
std::string_view next_number(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

bool comes_before(const std::string& left, const std::string& right) {
  std::string_view a = left, b = right;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a[0]) && is_digit(b[0])) {
      const std::string_view m = next_number(a), n = next_number(b);
      if (m != n) return m.size() != n.size() ? m.size() < n.size() : m < n;
      continue;
    }
    if (a[0] != b[0]) return a[0] < b[0];
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return left < right;
}

// Describes the first difference in topology from the first frame, if there is one.
std::optional<std::string> difference(const ImportedScene& first, const ImportedScene& frame) {
  const auto counts = [](const char* what, std::size_t one, std::size_t other) {
    return fmt::format("it has {} {}, the first frame has {}", other, what, one);
  };
  if (first.nodes.size() != frame.nodes.size())
    return counts("nodes", first.nodes.size(), frame.nodes.size());
  if (first.meshes.size() != frame.meshes.size())
    return counts("meshes", first.meshes.size(), frame.meshes.size());
  for (std::size_t i = 0; i < first.nodes.size(); ++i) {
    if (first.nodes[i].parent != frame.nodes[i].parent ||
        first.nodes[i].mesh != frame.nodes[i].mesh)
      return fmt::format("its node '{}' is not where the first frame has it", frame.nodes[i].name);
  }
  for (std::size_t m = 0; m < first.meshes.size(); ++m) {
    const ImportedMesh& one = first.meshes[m];
    const ImportedMesh& other = frame.meshes[m];
    if (one.vertices.size() != other.vertices.size())
      return counts("vertices", one.vertices.size(), other.vertices.size());
    if (one.faces.size() != other.faces.size())
      return counts("faces", one.faces.size(), other.faces.size());
    const auto [a, b] = std::mismatch(one.faces.begin(), one.faces.end(), other.faces.begin());
    if (a != one.faces.end()) {
      return fmt::format("its face {} names vertices {} {} {}, in the first frame {} {} {}",
                         a - one.faces.begin(), (*b)[0], (*b)[1], (*b)[2], (*a)[0], (*a)[1],
                         (*a)[2]);
    }
  }
  return {};
}

std::vector<bool> changed_nodes(const ImportedScene& first,
                                const std::vector<ImportedScene>& frames) {
  std::vector<bool> changed(first.nodes.size());
  for (const ImportedScene& frame : frames) {
    for (std::size_t i = 0; i < first.nodes.size(); ++i) {
      if (frame.nodes[i].parent_from_local != first.nodes[i].parent_from_local) changed[i] = true;
    }
  }
  return changed;
}

std::vector<bool> changed_meshes(const ImportedScene& first,
                                 const std::vector<ImportedScene>& frames) {
  std::vector<bool> changed(first.meshes.size());
  for (const ImportedScene& frame : frames) {
    for (std::size_t m = 0; m < first.meshes.size(); ++m) {
      if (frame.meshes[m].vertices != first.meshes[m].vertices) changed[m] = true;
    }
  }
  return changed;
}

// Moves the vertices of the frame into the pose.
Pose pose_of(ImportedScene& frame, const std::vector<bool>& nodes,
             const std::vector<bool>& meshes) {
  Pose pose;
  std::vector<std::vector<std::uint32_t>> nodes_of_mesh(frame.meshes.size());
  for (std::uint32_t i = 0; i < frame.nodes.size(); ++i) {
    const ImportedNode& node = frame.nodes[i];
    if (nodes[i]) pose.placed.push_back({i, node.parent_from_local});
    if (node.mesh != kNone && meshes[node.mesh]) nodes_of_mesh[node.mesh].push_back(i);
  }
  for (std::size_t m = 0; m < nodes_of_mesh.size(); ++m) {
    if (nodes_of_mesh[m].empty()) continue;
    pose.shaped.push_back({std::move(nodes_of_mesh[m]), std::move(frame.meshes[m].vertices)});
  }
  return pose;
}

// Keeps only the parts of a frame that are compared.
Result<ImportedScene> read_frame(const std::string& file, const ImportOptions& options,
                                 const ImportedScene& first, const std::string& first_file) {
  auto frame = import_scene(file, options);
  if (!frame) return frame.error();
  if (const auto different = difference(first, *frame)) {
    return import_error(
        fmt::format("{}: not the topology of {}: {}", file, first_file, *different));
  }
  for (ImportedMesh& mesh : frame->meshes) mesh.faces = {};
  return frame;
}

}  // namespace

Result<std::vector<std::string>> frame_files(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  if (error) return import_error(fmt::format("{}: {}", folder.string(), error.message()));
  std::vector<std::string> files;
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::filesystem::path& path = entry->path();
    std::error_code ignored;
    const bool is_scene = path.has_extension() && path.filename().string()[0] != '.' &&
                          is_read(extension_of(path.filename().string()));
    if (is_scene && entry->is_regular_file(ignored)) files.push_back(path.string());
  }
  if (error) return import_error(fmt::format("{}: {}", folder.string(), error.message()));
  if (files.empty()) return import_error(fmt::format("{}: holds no scene file", folder.string()));
  std::sort(files.begin(), files.end(), comes_before);
  return files;
}

Result<FrameSequence> import_sequence(const std::filesystem::path& folder,
                                      const ImportOptions& options,
                                      const ImportProgress& progress) {
  auto files = frame_files(folder);
  if (!files) return files.error();
  FrameSequence sequence;
  sequence.files = *std::move(files);
  std::vector<ImportedScene> frames;
  const std::string& first_file = sequence.files.front();
  auto first = import_animated_scene(first_file, options);
  if (!first) return first.error();
  sequence.scene = std::move(first->scene);
  ImportOptions like_first = options;
  like_first.offsets = first->rig.offsets;
  for (const std::string& file : sequence.files) {
    auto frame = read_frame(file, like_first, sequence.scene, first_file);
    if (!frame) return frame.error();
    std::vector<Warning>& warnings = sequence.scene.warnings;
    if (file != first_file)
      warnings.insert(warnings.end(), frame->warnings.begin(), frame->warnings.end());
    frames.push_back(*std::move(frame));
    if (progress) {
      progress(static_cast<double>(frames.size()) / static_cast<double>(sequence.files.size()));
    }
  }
  const std::vector<bool> nodes = changed_nodes(sequence.scene, frames);
  const std::vector<bool> meshes = changed_meshes(sequence.scene, frames);
  for (ImportedScene& frame : frames) sequence.frames.push_back(pose_of(frame, nodes, meshes));
  return sequence;
}

}  // namespace sightline::client::importer
