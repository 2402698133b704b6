// From the bytes of a file to plain arrays: check, choose the reader, read, convert.
#include "client/importer/read_scene.h"

#include <fmt/format.h>

#include <exception>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/importer/assimp_file.h"
#include "client/importer/completeness.h"
#include "client/importer/encoding.h"
#include "client/importer/extension.h"
#include "client/importer/gltf/read_gltf.h"
#include "client/importer/preflight.h"
#include "client/importer/scene_from_file.h"

namespace sightline::client::importer {
namespace {

// A binary STL file without facets, which Assimp refuses.
bool is_empty_stl(const SceneFile& file) {
  constexpr std::size_t kHeader = 80;
  constexpr std::string_view kNoFacets("\0\0\0\0", 4);
  return file.bytes.size() == kHeader + kNoFacets.size() && file.bytes.ends_with(kNoFacets);
}

Result<FileScene> read_stl(const SceneFile& file) {
  if (!is_empty_stl(file)) return read_with_assimp(file);
  FileScene scene;
  scene.nodes.emplace_back();
  return scene;
}

// A reader has the files that begin with its magic, and then those with its extension.
struct Reader {
  std::string_view extension, magic;
  Result<FileScene> (*read)(const SceneFile& file);
};
constexpr Reader kReaders[] = {
    {"glb", "glTF", gltf::read_gltf}, {"gltf", "", gltf::read_gltf}, {"stl", "", read_stl}};

// Assimp has all other formats.
auto reader_of(const SceneFile& file) {
  for (const Reader& reader : kReaders) {
    if (!reader.magic.empty() && file.bytes.starts_with(reader.magic)) return reader.read;
  }
  const std::string extension = extension_of(file.name);
  for (const Reader& reader : kReaders) {
    if (reader.extension == extension) return reader.read;
  }
  return read_with_assimp;
}

Result<AnimatedScene> read(const SceneFile& file) {
  if (const Status good = check_encoding(file.bytes); !good) return good.error();
  if (const Status good = preflight(file.bytes); !good) return good.error();
  auto doubts = check_complete(file.name, file.bytes);
  if (!doubts) return doubts.error();
  auto scene = reader_of(file)(file);
  if (!scene) return scene.error();
  scene->warnings.insert(scene->warnings.begin(), std::make_move_iterator(doubts->begin()),
                         std::make_move_iterator(doubts->end()));
  return scene_from_file(*std::move(scene), file.options);
}

}  // namespace

Result<AnimatedScene> read_scene(const std::string& name, const FileSource& files,
                                 const ImportOptions& options, const ImportProgress& progress) {
  const auto bytes = files(name);
  if (!bytes) return import_error("cannot be read");
  try {
    return read({name, *bytes, files, options, progress});
  } catch (const std::exception& e) {
    return import_error(fmt::format("damaged, or not understood by Assimp ({})", e.what()));
  }
}

}  // namespace sightline::client::importer
