// From Assimp's form to the imported scene.
#include "tests/fuzz/importer/check_made.h"

#include <utility>

#include "client/importer/file_scene_from_assimp.h"
#include "client/importer/scene_from_file.h"
#include "tests/fuzz/importer/check_imported.h"
#include "tests/fuzz/importer/made_scene.h"

namespace sightline::tests {

std::optional<std::string> check_made(std::span<const std::uint8_t> bytes, bool* taken) {
  const MadeScene made = make_scene(Bytes(bytes));
  auto file = client::importer::file_scene_from_assimp(*made.scene, made.importer_name);
  client::Result<client::importer::AnimatedScene> scene =
      file ? client::importer::scene_from_file(*std::move(file), made.options)
           : client::Result<client::importer::AnimatedScene>(file.error());
  if (taken != nullptr) *taken = scene.ok();
  if (scene) return check_animated(*scene);
  if (scene.error().message.empty()) return "refused without a word";
  return {};
}

}  // namespace sightline::tests
