// Each part is the size of a message, in the machine's order of bytes, and the message.
#include "server/codec/update_parts.h"

#include <google/protobuf/arena.h>

#include <cassert>
#include <cstdint>
#include <cstring>

#include "server/codec/update_codec.h"

namespace sightline::server::codec {
namespace {

void append(const v1::WatchSceneResponse& part, std::string& parts) {
  const auto size = static_cast<std::uint32_t>(part.ByteSizeLong());
  parts.append(reinterpret_cast<const char*>(&size), sizeof(size));
  part.AppendToString(&parts);
}

}  // namespace

std::string encode_parts(const std::vector<scenegraph::model::Update>& updates) {
  std::string parts;
  // Outside an arena a repeated field loses the message that it adds if its list cannot grow.
  google::protobuf::Arena arena;
  auto& part = *google::protobuf::Arena::CreateMessage<v1::WatchSceneResponse>(&arena);
  std::size_t bytes = 0;
  const auto end_part = [&] {
    append(part, parts);
    part.Clear();
    bytes = 0;
  };
  for (const scenegraph::model::Update& update : updates) {
    std::size_t row = 0;
    do {
      if (bytes >= kPartBytes) end_part();
      v1::Update& encoded = *part.add_updates();
      row = encode_update(update, row, kPartBytes - bytes, encoded);
      bytes += encoded.ByteSizeLong();
    } while (row != 0);
  }
  if (part.updates_size() > 0) append(part, parts);
  return parts;
}

void take_part(std::string_view& parts, v1::WatchSceneResponse& out) {
  std::uint32_t size = 0;
  std::memcpy(&size, parts.data(), sizeof(size));
  parts.remove_prefix(sizeof(size));
  [[maybe_unused]] const bool good = out.ParseFromArray(parts.data(), static_cast<int>(size));
  assert(good);
  parts.remove_prefix(size);
}

}  // namespace sightline::server::codec
