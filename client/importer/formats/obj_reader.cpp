// Reads statements line by line into objects and their parts, and makes meshes of the parts.
#include "client/importer/formats/obj_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/importer/formats/obj_groups.h"
#include "client/importer/formats/obj_unread.h"
#include "client/importer/formats/text.h"

namespace sightline::client::importer::formats {
namespace {

constexpr std::size_t kMost = 0xFFFFFFF0;  // vertices, or corners of faces

struct Line {
  std::string_view text;
  std::uint64_t number = 0;  // its first line's, if it is continued
  bool is_ended = true;
};

// Lines that end with a backslash are continued by the next one. Comments are not, as programs
// differ on them: a comment with a folder of Windows would take the next statement away.
class Lines {
 public:
  explicit Lines(std::string_view text) : cursor_(text) {}

  bool is_at_end() const { return cursor_.is_at_end(); }
  std::size_t at() const { return cursor_.at(); }

  Line next() {
    const std::uint64_t number = cursor_.line();
    std::string_view text = cursor_.rest_of_line();
    if (!text.ends_with('\\') || trimmed(text).starts_with('#'))
      return {text, number, cursor_.was_ended()};
    joined_.clear();
    while (text.ends_with('\\') && cursor_.was_ended()) {
      joined_.append(text.substr(0, text.size() - 1)).push_back(' ');
      text = cursor_.rest_of_line();
    }
    joined_.append(text);
    return {joined_, number, cursor_.was_ended()};
  }

 private:
  TextCursor cursor_;
  std::string joined_;
};

// A comment begins with a word, not within one.
std::string_view take_value(std::string_view& text) {
  const std::string_view word = take_word(text);
  if (!word.starts_with('#')) return word;
  text = {};
  return {};
}

// V, V/T, V//N or V/T/N; a slash may also end it. Only V matters.
std::optional<std::int64_t> vertex_of(std::string_view corner) {
  const std::size_t slash = corner.find('/');
  if (slash != std::string_view::npos &&
      corner.find_first_not_of("0123456789/-+", slash) != std::string_view::npos)
    return {};
  return integer(corner.substr(0, slash));
}

// A slash or a sign at the end of the last corner, and not of the others, stands for what is
// missing.
bool is_cut_off(std::string_view first, std::string_view last) {
  const auto slashes = [](std::string_view corner) {
    return std::count(corner.begin(), corner.end(), '/');
  };
  return last.ends_with('-') || (last.ends_with('/') && !first.ends_with('/')) ||
         slashes(last) < slashes(first);
}

class ObjReader {
 public:
  explicit ObjReader(const SceneFile& file) : file_(file), lines_(file.bytes) {}

  Result<FileScene> read() {
    ReadProgress progress(file_);
    while (!lines_.is_at_end()) {
      line_ = lines_.next();
      progress.reached(lines_.at());
      if (const Status good = read_line(); !good) return good.error();
    }
    if (const Status good = check_later_vertices(); !good) return good.error();
    FileScene scene = std::move(groups_).scene(file_.name, vertices_);
    scene.warnings = unread_.warnings();
    return scene;
  }

 private:
  Status read_line() {
    std::string_view rest = line_.text;
    const std::string_view keyword = take_value(rest);
    if (keyword.empty()) return {};
    Status good = read_statement(keyword, rest);
    if (line_.is_ended) return good;
    if (!good || !is_whole(keyword, line_.text.substr(line_.text.find(keyword) + keyword.size()))) {
      return import_error(fmt::format(
          "the file is cut off: its last line is no whole statement: '{}'", shown(line_.text)));
    }
    unread_.end_of_last_line();
    return {};
  }

  Status read_statement(std::string_view keyword, std::string_view rest) {
    if (keyword == "v") return read_vertex(rest);
    if (keyword == "f") return read_face(rest);
    if (keyword == "l") return read_line_elements(rest);
    if (keyword == "p") return read_points(rest);
    if (keyword == "g") {
      groups_.open_group(trimmed(rest));
    } else if (keyword == "o") {
      groups_.open_object(trimmed(rest));
    } else if (keyword == "usemtl") {
      groups_.use_material(trimmed(rest));
    } else {
      unread_.statement(keyword, line_.number);
    }
    return {};
  }

  // Whether the last line of the file can be a whole statement.
  bool is_whole(std::string_view keyword, std::string_view rest) const {
    std::vector<std::string_view> words;
    for (std::string_view word = take_value(rest); !word.empty(); word = take_value(rest))
      words.push_back(word);
    if (keyword == "f" || keyword == "l")
      return words.size() >= (keyword == "f" ? 3 : 2) && !is_cut_off(words.front(), words.back());
    const std::size_t fewest = keyword == "v" || keyword == "vn"   ? 3
                               : keyword == "vt" || keyword == "p" ? 1
                                                                   : 0;
    return words.size() >= fewest &&
           (fewest == 0 || std::all_of(words.begin(), words.end(),
                                       [](std::string_view word) { return number(word); }));
  }

  Error error(const std::string& what) const {
    return import_error(fmt::format("line {}: {}", line_.number, what));
  }

  // x y z, and a weight, a color, or both.
  Status read_vertex(std::string_view rest) {
    Point position{};
    for (std::size_t k = 0; k < position.size(); ++k) {
      const std::string_view word = take_value(rest);
      if (word.empty()) return error(fmt::format("a vertex has {} numbers, must have 3", k));
      const auto value = number(word);
      if (!value) return error(not_a_number(word));
      position[k] = *value;
    }
    if (vertices_.size() == kMost) return error(fmt::format("more than {} vertices", kMost));
    vertices_.push_back(position);
    std::size_t more = 0;
    double weight = 1;
    for (std::string_view word = take_value(rest); !word.empty(); word = take_value(rest)) {
      const auto value = number(word);
      if (!value) return error(not_a_number(word));
      if (more++ == 0) weight = *value;
    }
    if (more == 1 && weight != 1) unread_.weight(line_.number);
    return {};
  }

  // Vertices count from 1, or back from the last one if negative.
  Status take_corners(std::string_view rest) {
    corners_.clear();
    for (std::string_view word = take_value(rest); !word.empty(); word = take_value(rest)) {
      const auto index = vertex_of(word);
      if (!index) return error(fmt::format("'{}' is no corner of a face", shown(word)));
      const auto count = static_cast<std::int64_t>(vertices_.size());
      const std::int64_t vertex = *index > 0 ? *index - 1 : count + *index;
      if (*index == 0 || vertex < 0) return error(no_vertex(*index, count));
      if (vertex >= count) {
        if (vertex >= static_cast<std::int64_t>(kMost)) return error(no_vertex(*index, count));
        later_.push_back({line_.number, *index});
      }
      corners_.push_back(static_cast<std::uint32_t>(vertex));
    }
    if (groups_.corners() + 2 * corners_.size() > kMost)
      return error(fmt::format("more than {} corners of faces", kMost));
    return {};
  }

  static std::string no_vertex(std::int64_t index, std::int64_t count) {
    if (index == 0) return "a face names vertex 0, but the first one is 1";
    return fmt::format("a face names vertex {}, but there are {}", index, count);
  }

  Status read_face(std::string_view rest) {
    if (Status good = take_corners(rest); !good) return good;
    if (corners_.empty()) {
      unread_.empty_face(line_.number);
    } else {
      groups_.add_face(corners_);
    }
    return {};
  }

  Status read_line_elements(std::string_view rest) {
    if (Status good = take_corners(rest); !good) return good;
    for (std::size_t k = 0; k + 1 < corners_.size(); ++k)
      groups_.add_face({corners_.data() + k, 2});
    return {};
  }

  Status read_points(std::string_view rest) {
    if (Status good = take_corners(rest); !good) return good;
    for (const std::uint32_t& corner : corners_) groups_.add_face({&corner, 1});
    return {};
  }

  // Faces may come before their vertices.
  Status check_later_vertices() {
    const auto count = static_cast<std::int64_t>(vertices_.size());
    for (const auto& [line, index] : later_) {
      if (index <= count) continue;
      return import_error(fmt::format("line {}: {}", line, no_vertex(index, count)));
    }
    return {};
  }

  struct Later {
    std::uint64_t line;
    std::int64_t index;
  };

  const SceneFile& file_;
  Lines lines_;
  Line line_;
  std::vector<Point> vertices_;
  ObjGroups groups_;
  ObjUnread unread_;
  std::vector<std::uint32_t> corners_;  // corners of the face that is read
  std::vector<Later> later_;            // corners whose vertices did not exist yet
};

}  // namespace

Result<FileScene> read_obj(const SceneFile& file) { return ObjReader(file).read(); }

}  // namespace sightline::client::importer::formats
