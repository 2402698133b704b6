// From the bytes of a file to plain arrays: check, choose the reader, read, convert.
#include "client/importer/read_scene.h"

#include <fmt/format.h>

#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include "client/importer/assimp_file.h"
#include "client/importer/completeness.h"
#include "client/importer/encoding.h"
#include "client/importer/extension.h"
#include "client/importer/formats/obj_reader.h"
#include "client/importer/formats/ply_reader.h"
#include "client/importer/formats/stl_reader.h"
#include "client/importer/gltf/read_gltf.h"
#include "client/importer/scene_from_file.h"
#include "client/importer/unread_formats.h"

namespace sightline::client::importer {
namespace {

// A reader has the files that begin with its magic, and then those with its extension.
struct Reader {
  std::string_view extension, magic;
  Result<FileScene> (*read)(const SceneFile& file);
};
constexpr Reader kReaders[] = {{"glb", "glTF", gltf::read_gltf},
                               {"gltf", "", gltf::read_gltf},
                               {"obj", "", formats::read_obj},
                               {"ply", "ply", formats::read_ply},
                               {"stl", "", formats::read_stl}};

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
  if (file.bytes.empty()) return import_error("the file is empty");
  if (const Status good = check_format(file.name, file.bytes); !good) return good.error();
  if (const Status good = check_encoding(file.bytes); !good) return good.error();
  if (const Status good = check_complete(file.bytes); !good) return good.error();
  auto scene = reader_of(file)(file);
  if (!scene) return scene.error();
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
