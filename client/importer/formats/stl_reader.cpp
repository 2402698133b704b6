// A file of exactly the size that its count of facets needs is binary, whatever it begins with.
#include "client/importer/formats/stl_reader.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "client/importer/formats/stl_text.h"
#include "client/importer/formats/text.h"

namespace sightline::client::importer::formats {
namespace {

constexpr std::size_t kHeader = 84;  // the last four bytes are the number of facets
constexpr std::size_t kFacet = 50;   // a normal, three vertices, two bytes
constexpr std::size_t kNormal = 12;
constexpr std::size_t kLooked = 4096;  // bytes, to tell text from binary
constexpr std::uint64_t kMostFacets = 0xFFFFFFF0 / 3;
constexpr std::uint32_t kUnknown = 0xFFFFFFFF;  // written by programs that do not know the number

template <class T>
T load(const char* from) {
  T value{};
  std::memcpy(&value, from, sizeof(T));
  return value;
}

std::uint32_t count_of(std::string_view bytes) {
  return load<std::uint32_t>(bytes.data() + kHeader - sizeof(std::uint32_t));
}

bool has_announced_size(std::string_view bytes) {
  return bytes.size() >= kHeader &&
         bytes.size() == kHeader + std::uint64_t{kFacet} * count_of(bytes);
}

// A binary file has a zero among its first numbers.
bool is_text(std::string_view bytes) {
  return bytes.substr(0, kLooked).find('\0') == std::string_view::npos;
}

Warning warning(const char* kind, std::uint64_t count, std::string message) {
  return {kind, count, "", std::move(message)};
}

// How many facets are read, and why, if the count and the size differ.
Result<std::uint64_t> facets_of(std::string_view bytes, std::vector<Warning>& warnings) {
  const std::uint64_t announced = count_of(bytes);
  const std::uint64_t held = (bytes.size() - kHeader) / kFacet;
  const std::uint64_t surplus = (bytes.size() - kHeader) % kFacet;
  if (announced == held && surplus == 0) return held;
  // Another number is wrong if the facets fill the file, and right if something follows them.
  const bool is_right = announced == held || (announced > 0 && announced < held && surplus != 0);
  if (announced > held && surplus != 0 && announced != kUnknown) {
    return import_error(fmt::format(
        "the file is cut off: its header announces {} facets, which need {} bytes, and it has {}",
        announced, kHeader + kFacet * announced, bytes.size()));
  }
  if (!is_right) {
    warnings.push_back(warning(
        "wrong_count", 1,
        fmt::format("its header announces {} facets, but by its size it has {}, which are read",
                    announced, held)));
  }
  const std::uint64_t count = is_right ? announced : held;
  const std::uint64_t left = bytes.size() - kHeader - kFacet * count;
  if (left > 0) {
    warnings.push_back(warning(
        "surplus_bytes", left,
        fmt::format("{} bytes follow its last facet and are not read: its size of {} bytes is not "
                    "84 + 50 x {}",
                    left, bytes.size(), count)));
  }
  return count;
}

Result<FileScene> read_binary(const SceneFile& file) {
  FileScene scene;
  const auto count = facets_of(file.bytes, scene.warnings);
  if (!count) return count.error();
  if (*count > kMostFacets) return import_error(fmt::format("more than {} facets", kMostFacets));
  FileMesh mesh;
  mesh.vertices.reserve(3 * *count);
  ReadProgress progress(file);
  for (std::uint64_t i = 0; i < *count; ++i) {
    const char* from = file.bytes.data() + kHeader + kFacet * i + kNormal;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Point vertex{};
      for (double& x : vertex) {
        x = static_cast<double>(load<float>(from));
        from += sizeof(float);
      }
      add_stl_vertex(mesh, vertex);
    }
    mesh.faces.first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    progress.reached(kHeader + kFacet * i);
  }
  scene.meshes.push_back(std::move(mesh));
  scene.nodes = {{.name = "<STL_BINARY>", .meshes = {}}, {.name = {}, .parent = 0, .meshes = {0}}};
  return scene;
}

}  // namespace

Result<FileScene> read_stl(const SceneFile& file) {
  if (has_announced_size(file.bytes)) return read_binary(file);
  if (is_text(file.bytes)) {
    if (in_lower_case(TextCursor(file.bytes).word()) == "solid") return read_stl_text(file);
    return import_error("no STL file: it is text and does not begin with 'solid'");
  }
  if (file.bytes.size() >= kHeader) return read_binary(file);
  return import_error(fmt::format("no STL file: it has {} bytes, and a binary header {}",
                                  file.bytes.size(), kHeader));
}

}  // namespace sightline::client::importer::formats
