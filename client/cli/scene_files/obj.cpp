// Moves each mesh by the product of the transforms above it.
#include <fmt/format.h>

#include <iterator>
#include <string>
#include <unordered_map>
#include <vector>

#include "client/cli/scene_files/scene_format.h"
#include "client/cli/terminal.h"
#include "client/importer/affine.h"

namespace sightline::client::cli::scene_files {
namespace {

using importer::ImportedMesh;
using importer::ImportedNode;
using importer::ImportedScene;
using importer::operator*;

constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

class ObjText {
 public:
  explicit ObjText(const ByteSink& sink) : sink_(sink) {}

  Status add(const std::string& name, const Transform& scene_from_local, const ImportedMesh& mesh) {
    // Readers take objects with one name for one object.
    const std::uint64_t before = names_[name]++;
    fmt::format_to(std::back_inserter(text_), "o {}{}\n", printable(name),
                   before == 0 ? "" : fmt::format("#{}", before));
    for (const Vertex& vertex : mesh.vertices) {
      const auto p = scene_from_local * importer::Point{static_cast<double>(vertex[0]),
                                                        static_cast<double>(vertex[1]),
                                                        static_cast<double>(vertex[2])};
      fmt::format_to(std::back_inserter(text_), "v {} {} {}\n", p[0], p[1], p[2]);
      if (Status sent = flush(kPieceBytes); !sent) return sent;
    }
    for (const Face& face : mesh.faces) {
      if (face[0] == kNoVertex) continue;
      fmt::format_to(std::back_inserter(text_), "f {} {} {}\n", first_ + face[0], first_ + face[1],
                     first_ + face[2]);
      if (Status sent = flush(kPieceBytes); !sent) return sent;
    }
    first_ += mesh.vertices.size();
    return {};
  }

  /// Sends the text if it has this number of bytes.
  Status flush(std::size_t least) {
    if (text_.size() < least) return {};
    Status sent = sink_(text_);
    text_.clear();
    return sent;
  }

 private:
  const ByteSink& sink_;
  std::string text_;
  std::unordered_map<std::string, std::uint64_t> names_;  // how often each was used
  std::uint64_t first_ = 1;  // vertices are counted from 1 through the whole file
};

}  // namespace

Status write_obj(const ImportedScene& scene, const ByteSink& sink) {
  ObjText text(sink);
  std::vector<Transform> transforms;
  transforms.reserve(scene.nodes.size());
  for (const ImportedNode& node : scene.nodes) {
    const bool is_root = node.parent == importer::kNone;
    transforms.push_back(is_root ? node.parent_from_local
                                 : transforms[node.parent] * node.parent_from_local);
    if (node.mesh == importer::kNone) continue;
    Status added = text.add(node.name, transforms.back(), scene.meshes[node.mesh]);
    if (!added) return added;
  }
  return text.flush(0);
}

}  // namespace sightline::client::cli::scene_files
