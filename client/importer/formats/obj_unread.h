// Counts what an OBJ file says and what is not read. Internal to the importer.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer::formats {

class ObjUnread {
 public:
  /// Counts a statement that adds no polygon, line or point.
  void statement(std::string_view keyword, std::uint64_t line);
  /// Counts a vertex with a weight other than 1.
  void weight(std::uint64_t line);
  void empty_face(std::uint64_t line);
  /// Notes that the last line is whole, and has no end.
  void end_of_last_line();

  /// A warning for each kind that was counted.
  std::vector<Warning> warnings() const;

 private:
  struct Count {
    std::uint64_t count = 0;
    std::string first;  // the first one: its line and keyword

    void add(std::uint64_t line, std::string_view keyword = {});
  };

  Count curves_, calls_, unknown_, weights_, empty_faces_;
  bool has_last_line_end_ = true;
};

}  // namespace sightline::client::importer::formats
