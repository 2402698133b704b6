// Reads word after word; ends of lines only end names.
#include "client/importer/formats/stl_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "client/importer/formats/text.h"

namespace sightline::client::importer::formats {
namespace {

constexpr std::size_t kMostVertices = 0xFFFFFFF0;

// Keywords in lower case; `end facet` is one, too.
std::string next_keyword(TextCursor& text) {
  std::string word = in_lower_case(text.word());
  if (word == "end") word += in_lower_case(text.word());
  return word;
}

// A name ends with its line, or before a facet on the same line.
std::string_view take_name(TextCursor& text) {
  TextCursor after = text;
  const std::string_view line = after.rest_of_line();
  std::string_view rest = line;
  for (std::size_t words = 0; !trimmed(rest).empty(); ++words) {
    const std::size_t begin = line.size() - rest.size();
    if (in_lower_case(take_word(rest)) != "facet") continue;
    std::string_view next = rest;
    if (in_lower_case(take_word(next)) != "normal") continue;
    for (; words > 0; --words) text.word();
    return trimmed(line.substr(0, begin));
  }
  text = after;
  return trimmed(line);
}

class StlTextReader {
 public:
  explicit StlTextReader(const SceneFile& file) : file_(file), text_(file.bytes) {}

  Result<FileScene> read() {
    ReadProgress progress(file_);
    for (std::string keyword = next_keyword(text_); !keyword.empty();
         keyword = next_keyword(text_)) {
      if (const Status good = read_statement(keyword); !good) return good.error();
      progress.reached(text_.at());
    }
    return scene();
  }

 private:
  Status read_statement(const std::string& keyword) {
    if (keyword == "facet") return read_facet();
    if (keyword == "solid") {
      begin_solid(std::string(take_name(text_)));
    } else if (keyword == "endsolid") {
      is_open_ = false;
      text_.rest_of_line();
    } else {
      if (unknown_++ == 0)
        first_unknown_ = fmt::format("line {}: {}", text_.line(), shown(keyword));
      text_.rest_of_line();
    }
    return {};
  }

  void begin_solid(std::string name) {
    meshes_.emplace_back().name = std::move(name);
    is_open_ = true;
  }

  // Up to endfacet. A facet in which the file ends is left out.
  Status read_facet() {
    if (meshes_.empty() || !is_open_) begin_solid({});
    const std::uint64_t line = text_.line();
    std::vector<Point> corners;
    for (std::string keyword = next_keyword(text_); keyword != "endfacet";
         keyword = next_keyword(text_)) {
      if (keyword.empty()) return {};
      if (keyword == "facet" || keyword == "solid" || keyword == "endsolid") {
        return import_error(
            fmt::format("line {}: '{}' before the end of a facet", text_.line(), keyword));
      }
      if (keyword != "vertex") continue;
      if (text_.is_at_end()) return {};
      if (Status good = read_vertex(corners.emplace_back()); !good) {
        if (text_.is_at_end()) return {};
        return good;
      }
    }
    if (corners.size() != 3) {
      return import_error(
          fmt::format("line {}: a facet has {} vertices, must have 3", line, corners.size()));
    }
    FileMesh& mesh = meshes_.back();
    if (mesh.vertices.size() > kMostVertices)
      return import_error(fmt::format("more than {} vertices", kMostVertices));
    for (const Point& corner : corners) add_stl_vertex(mesh, corner);
    mesh.faces.first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    return {};
  }

  Status read_vertex(Point& vertex) {
    for (double& x : vertex) {
      const std::string_view word = text_.word();
      const auto value = number(word);
      if (!value) return import_error(fmt::format("line {}: {}", text_.line(), not_a_number(word)));
      x = *value;
    }
    return {};
  }

  FileScene scene() {
    FileScene scene;
    if (unknown_ > 0) {
      scene.warnings.push_back(
          {"unknown_statements", unknown_, first_unknown_,
           fmt::format("{} lines begin with an unknown word and are not read (first in {})",
                       unknown_, first_unknown_)});
    }
    if (is_open_) {
      scene.warnings.push_back(
          {"cut_off", 1, "", "it does not end with endsolid; the file may be cut off"});
    }
    const bool all_named = std::all_of(meshes_.begin(), meshes_.end(),
                                       [](const FileMesh& mesh) { return !mesh.name.empty(); });
    scene.nodes.push_back({.name = all_named ? "" : "<STL_ASCII>", .meshes = {}});
    for (FileMesh& mesh : meshes_) {
      const auto index = static_cast<std::uint32_t>(scene.meshes.size());
      scene.nodes.push_back({.name = mesh.name, .parent = 0, .meshes = {index}});
      scene.meshes.push_back(std::move(mesh));
    }
    return scene;
  }

  const SceneFile& file_;
  TextCursor text_;
  std::vector<FileMesh> meshes_;  // one for each solid
  bool is_open_ = false;          // whether the last solid has no end yet
  std::uint64_t unknown_ = 0;
  std::string first_unknown_;
};

}  // namespace

Result<FileScene> read_stl_text(const SceneFile& file) { return StlTextReader(file).read(); }

void add_stl_vertex(FileMesh& mesh, const Point& vertex) {
  mesh.faces.corners.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
  mesh.vertices.push_back(vertex);
}

}  // namespace sightline::client::importer::formats
