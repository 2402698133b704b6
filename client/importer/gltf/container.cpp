// Walks the chunks of a GLB file.
#include "client/importer/gltf/container.h"

#include <cstddef>
#include <cstdint>

#include "client/importer/gltf/refusal.h"

namespace sightline::client::importer::gltf {
namespace {

constexpr std::string_view kMagic = "glTF";
constexpr std::size_t kHeader = 12, kChunkHeader = 8;
constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

}  // namespace

Container open_container(std::string_view file) {
  if (!file.starts_with(kMagic)) return {file, {}};
  if (file.size() < kHeader) refuse("it is cut off: a GLB file of {} bytes", file.size());
  const std::uint32_t version = little_endian(file.substr(4));
  if (version == 1) {
    refuse(
        "it is glTF 1.0, which is not read; convert it to glTF 2.0, with gltf-pipeline, for "
        "example");
  }
  if (version != 2) refuse("it is GLB of version {}; version 2 is read", version);
  const std::uint32_t length = little_endian(file.substr(8));
  if (length > file.size())
    refuse("it is cut off: it has {} bytes, its header says {}", file.size(), length);
  const std::string_view whole = file.substr(0, length);
  Container out;
  for (std::size_t at = kHeader, chunk = 0; at + kChunkHeader <= whole.size(); ++chunk) {
    const std::uint32_t size = little_endian(whole.substr(at));
    const std::uint32_t type = little_endian(whole.substr(at + 4));
    at += kChunkHeader;
    if (size > whole.size() - at) {
      refuse("it is cut off: a chunk of {} bytes is said to begin at byte {} of {}", size, at,
             whole.size());
    }
    if (chunk == 0 && type != kJson) refuse("its first chunk is no JSON");
    if (chunk == 0) out.json = whole.substr(at, size);
    if (chunk == 1 && type == kBinary) out.binary = whole.substr(at, size);
    at += size;
  }
  if (out.json.empty()) refuse("it is a GLB file without JSON");
  return out;
}

}  // namespace sightline::client::importer::gltf
