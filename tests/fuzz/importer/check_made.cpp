// The plain and the animated import, which must agree.
#include "tests/fuzz/importer/check_made.h"

#include "client/importer/lattice.h"
#include "client/importer/read_scene.h"
#include "tests/fuzz/importer/check_imported.h"
#include "tests/fuzz/importer/made_scene.h"

namespace sightline::tests {

std::optional<std::string> check_made(std::span<const std::uint8_t> bytes, bool* taken) {
  const MadeScene made = make_scene(Bytes(bytes));
  auto plain = client::importer::convert_scene(*made.scene, made.importer_name, made.options);
  const auto animated =
      client::importer::convert_animated_scene(*made.scene, made.importer_name, made.options);
  if (taken != nullptr) *taken = animated.ok();
  if (!plain) {
    if (plain.error().message.empty()) return "refused without a word";
    return animated ? std::optional<std::string>("only taken if animated") : std::nullopt;
  }
  if (auto wrong = check_imported(*plain)) return wrong;
  if (!animated && animated.error().message.empty()) return "refused without a word";
  client::importer::rebase(*plain);
  if (auto wrong = check_imported(*plain)) return wrong;
  if (!animated) return {};
  if (auto wrong = difference(*plain, animated->scene)) return wrong;
  return check_animated(*animated);
}

}  // namespace sightline::tests
