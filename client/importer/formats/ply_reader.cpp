// Reads element after element, in the order of the header.
#include "client/importer/formats/ply_reader.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "client/importer/formats/ply_header.h"
#include "client/importer/formats/ply_values.h"
#include "client/importer/formats/text.h"

namespace sightline::client::importer::formats {
namespace {

constexpr std::size_t kMostCorners = 0xFFFFFFF0;

// The property that lists a face's vertices; properties.size() if there is none.
std::size_t find_corners(const PlyElement& element) {
  const std::size_t found = element.find("vertex_indices");
  return found < element.properties.size() ? found : element.find("vertex_index");
}

class PlyReader {
 public:
  PlyReader(const SceneFile& file, PlyHeader header)
      : file_(file),
        header_(std::move(header)),
        values_(file.bytes, header_),
        warnings_(header_.warnings) {}

  Result<FileScene> read() {
    if (const Status good = check_vertices(); !good) return good.error();
    for (const PlyElement& element : header_.elements) {
      if (const Status good = read_elements(element); !good) return good.error();
    }
    const auto surplus = values_.surplus_bytes();
    if (!surplus) return surplus.error();
    FileScene scene;
    scene.warnings = std::move(warnings_);
    if (*surplus > 0) {
      scene.warnings.push_back(
          {"surplus_bytes", *surplus, "",
           fmt::format("{} bytes follow its last element and are not read", *surplus)});
    }
    if (const std::uint64_t line = values_.long_line(); line > 0) {
      scene.warnings.push_back(
          {"line_breaks", 1, fmt::format("line {}", line),
           fmt::format("line {} has more values than its element: the next element begins on it",
                       line)});
    }
    scene.meshes.push_back(std::move(mesh_));
    scene.nodes.push_back({.name = {}, .meshes = {0}});
    return scene;
  }

 private:
  Status check_vertices() {
    for (const PlyElement& element : header_.elements) {
      if (element.name != "vertex") continue;
      for (std::size_t k = 0; k < position_.size(); ++k) {
        const char axis[] = {"xyz"[k], '\0'};
        position_[k] = element.find(axis);
        if (position_[k] < element.properties.size() && !element.properties[position_[k]].is_list)
          continue;
        return import_error(fmt::format("its vertices have no property '{}'", axis));
      }
      vertex_count_ = element.count;
      return {};
    }
    return import_error("the PLY header has no element 'vertex'");
  }

  Status read_elements(const PlyElement& element) {
    const bool is_face = element.name == "face", is_strip = element.name == "tristrips";
    const std::size_t corners = find_corners(element);
    const bool is_list = corners < element.properties.size() && element.properties[corners].is_list;
    if ((is_face || is_strip) && element.count > 0 && !is_list) {
      return import_error(
          fmt::format("its elements '{}' have no list 'vertex_indices'", shown(element.name)));
    }
    if (!values_.has(element)) return values_.error();
    if (element.name == "vertex") return read_vertices(element);
    if (!is_face && !is_strip) return skip(element);
    ReadProgress progress(file_);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Status good = read_corners(element, corners);
      if (good) good = is_face ? add_face(i) : add_strip(i);
      if (!good) return good;
      progress.reached(values_.at());
    }
    return {};
  }

  Status read_vertices(const PlyElement& element) {
    mesh_.vertices.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Point vertex{};
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        const std::size_t k = p == position_[0] ? 0 : p == position_[1] ? 1 : 2;
        if (p == position_[k] ? !values_.next(property.type, vertex[k]) : !values_.skip(property))
          return values_.error();
      }
      values_.end_element();
      mesh_.vertices.push_back(vertex);
    }
    return {};
  }

  Status skip(const PlyElement& element) {
    const bool is_empty = element.count == 0 || element.properties.empty();
    if (!is_empty) {
      warnings_.push_back(
          {"unread_elements", element.count, shown(element.name),
           fmt::format("its {} elements '{}' are not read", element.count, shown(element.name))});
    }
    for (std::uint64_t i = 0; i < element.count && !is_empty; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (!values_.skip(property)) return values_.error();
      }
      values_.end_element();
    }
    return {};
  }

  Status read_corners(const PlyElement& element, std::size_t corners) {
    list_.clear();
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (p != corners) {
        if (!values_.skip(property)) return values_.error();
        continue;
      }
      std::uint64_t length = 0;
      if (!values_.next_length(property, length)) return values_.error();
      for (; length > 0; --length) {
        double& index = list_.emplace_back();
        if (!values_.next(property.type, index)) return values_.error();
      }
    }
    values_.end_element();
    return {};
  }

  bool is_vertex(double index) const {
    return index >= 0 && index < static_cast<double>(vertex_count_) && index == std::floor(index);
  }

  Error no_vertex(const char* what, std::uint64_t number, double index) const {
    return import_error(
        fmt::format("{} {} names vertex {}, but there are {}", what, number, index, vertex_count_));
  }

  Status add_face(std::uint64_t number) {
    for (const double index : list_) {
      if (!is_vertex(index)) return no_vertex("face", number, index);
      mesh_.faces.corners.push_back(static_cast<std::uint32_t>(index));
    }
    return end_face();
  }

  // Every second triangle of a strip is turned over, so that all have one outside.
  Status add_strip(std::uint64_t number) {
    constexpr double kUnsignedEnd = 4294967295;  // -1 without a sign
    std::uint32_t first = 0, second = 0;
    std::size_t length = 0;
    for (const double index : list_) {
      if (index == -1 || index == kUnsignedEnd) {
        length = 0;
        continue;
      }
      if (!is_vertex(index)) return no_vertex("strip", number, index);
      const auto third = static_cast<std::uint32_t>(index);
      if (length >= 2) {
        const bool is_turned = length % 2 == 1;
        for (const std::uint32_t corner :
             {is_turned ? second : first, is_turned ? first : second, third})
          mesh_.faces.corners.push_back(corner);
        if (Status good = end_face(); !good) return good;
      }
      first = std::exchange(second, third);
      ++length;
    }
    return {};
  }

  Status end_face() {
    if (mesh_.faces.corners.size() > kMostCorners)
      return import_error(fmt::format("more than {} corners of faces", kMostCorners));
    mesh_.faces.first.push_back(static_cast<std::uint32_t>(mesh_.faces.corners.size()));
    return {};
  }

  const SceneFile& file_;
  PlyHeader header_;
  PlyValues values_;
  std::array<std::size_t, 3> position_{};  // indices of the properties x, y, z
  std::uint64_t vertex_count_ = 0;
  std::vector<double> list_;  // values of the element that is read
  FileMesh mesh_;
  std::vector<Warning> warnings_;
};

}  // namespace

Result<FileScene> read_ply(const SceneFile& file) {
  auto header = read_ply_header(file.bytes);
  if (!header) return header.error();
  return PlyReader(file, *std::move(header)).read();
}

}  // namespace sightline::client::importer::formats
