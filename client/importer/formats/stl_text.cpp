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

bool has_facet_on_line(TextCursor text) {
  if (!text.has_word_on_line() || in_lower_case(text.word()) != "facet") return false;
  return text.has_word_on_line() && in_lower_case(text.word()) == "normal";
}

// A name ends with its line, or before a facet on the same line.
std::string_view take_name(std::string_view bytes, TextCursor& text) {
  const std::size_t begin = text.at();
  while (text.has_word_on_line() && !has_facet_on_line(text)) text.word();
  const std::size_t end = text.at();
  return trimmed(bytes.substr(begin, end - begin));
}

// The name after endsolid, and on the same line there may be the next solid and its name.
std::string_view take_next_solid(std::string_view bytes, TextCursor& text) {
  std::string_view line = take_name(bytes, text);
  if (!text.has_word_on_line()) return {};
  while (!line.empty() && in_lower_case(take_word(line)) != "solid") {
  }
  return trimmed(line);
}

// The words of a facet but its vertices: normal and three numbers, outer loop, endloop, each once,
// and none must be there.
class FacetWords {
 public:
  /// `word` in lower case, after this number of vertices.
  bool is_in_order(const std::string& word, std::size_t vertices) {
    if (word == "vertex") return !is_closed_;
    if (word == "endloop") return vertices > 0 && !std::exchange(is_closed_, true);
    if (vertices > 0) return false;
    if (normal_ > 0 && normal_ < kNormal && begins_as_number(word)) return normal_++ > 0;
    if (word == "normal") return normal_++ == 0 && !is_outer_;
    if (word == "outer") return !std::exchange(is_outer_, true);
    return word == "loop" && is_outer_ && !std::exchange(is_loop_, true);
  }

 private:
  // Normals are not read, and are often no numbers: nan, -1.#IND, inf.
  static bool begins_as_number(const std::string& word) {
    return word.find_first_of("+-.0123456789ni") == 0 && word != "normal";
  }

  static constexpr int kNormal = 4;  // the word and three numbers

  int normal_ = 0;  // how many words of it were read
  bool is_outer_ = false, is_loop_ = false, is_closed_ = false;
};

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
      begin_solid(take_name(file_.bytes, text_));
    } else if (keyword == "endsolid") {
      is_open_ = false;
      const std::string_view name = take_next_solid(file_.bytes, text_);
      if (text_.has_word_on_line()) begin_solid(name);
    } else {
      note_unknown(keyword);
      text_.rest_of_line();
    }
    return {};
  }

  void begin_solid(std::string_view name) {
    meshes_.emplace_back().name = name;
    is_open_ = true;
  }

  // Reads a facet up to endfacet. One in which the file ends is left out.
  Status read_facet() {
    if (meshes_.empty() || !is_open_) begin_solid({});
    const std::uint64_t line = text_.line();
    std::vector<Point> corners;
    FacetWords words;
    for (std::string keyword = next_keyword(text_); keyword != "endfacet";
         keyword = next_keyword(text_)) {
      if (keyword.empty()) return {};
      if (keyword == "facet" || keyword == "solid" || keyword == "endsolid") {
        return import_error(
            fmt::format("line {}: '{}' before the end of a facet", text_.line(), keyword));
      }
      if (!words.is_in_order(keyword, corners.size())) note_unknown(keyword);
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

  void note_unknown(const std::string& word) {
    if (unknown_++ == 0) first_unknown_ = fmt::format("line {}: {}", text_.line(), shown(word));
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
           fmt::format("{} words are not where STL has them and are not read (first in {})",
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
