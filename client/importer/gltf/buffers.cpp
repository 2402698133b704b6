// Finds bytes in the file itself, in other files, and in data URIs.
#include "client/importer/gltf/buffers.h"

#include "client/importer/gltf/meshopt.h"
#include "client/importer/gltf/uri.h"

namespace sightline::client::importer::gltf {

Buffers::Buffers(const Document& document, const Container& container, const FileSource& files)
    : document_(document), container_(container), files_(files) {}

Buffers::View Buffers::view(std::uint64_t index, std::string_view by) {
  const Item item = document_.at("bufferViews", index, by);
  if (const auto compressed = item.extension("EXT_meshopt_compression"))
    return {decompressed(index, item, *compressed), compressed->integer("byteStride")};
  return {part(item), item.integer("byteStride", 0)};
}

std::string_view Buffers::buffer(std::uint64_t index, std::string_view by) {
  const auto known = buffers_.find(index);
  if (known != buffers_.end()) return known->second;
  const Item item = document_.at("buffers", index, by);
  const std::string_view bytes = read(item, index);
  const std::uint64_t length = item.integer("byteLength");
  if (bytes.size() < length) {
    refuse("{} has {} bytes, its byteLength is {}; the file may be cut off", item.where(),
           bytes.size(), length);
  }
  return buffers_[index] = bytes.substr(0, length);
}

std::string_view Buffers::read(const Item& item, std::uint64_t index) {
  if (!item.has("uri")) {
    if (index == 0 && container_.binary) return *container_.binary;
    refuse("{} has no uri, and no bytes in the file", item.where());
  }
  const std::string uri = item.text("uri");
  if (is_data_uri(uri)) return decoded_[index] = decode_data_uri(uri, item.where());
  const auto bytes = files_(percent_decoded(uri));
  if (!bytes) refuse("{}: its uri '{}' cannot be read", item.where(), uri.substr(0, 200));
  return *bytes;
}

std::string_view Buffers::part(const Item& item) {
  const std::string_view bytes = buffer(item.integer("buffer"), item.where());
  const std::uint64_t offset = item.integer("byteOffset", 0), length = item.integer("byteLength");
  if (offset > bytes.size() || length > bytes.size() - offset) {
    refuse("{} has {} bytes from byte {}, but its buffer has {}", item.where(), length, offset,
           bytes.size());
  }
  return bytes.substr(offset, length);
}

std::string_view Buffers::decompressed(std::uint64_t index, const Item& view,
                                       const Item& compressed) {
  const auto known = decompressed_.find(index);
  if (known != decompressed_.end()) return known->second;
  std::string bytes = decompress_meshopt(compressed, part(compressed));
  if (bytes.size() < view.integer("byteLength")) {
    refuse("{} has {} bytes when it is decompressed, its byteLength is {}", view.where(),
           bytes.size(), view.integer("byteLength"));
  }
  return decompressed_[index] = std::move(bytes);
}

}  // namespace sightline::client::importer::gltf
