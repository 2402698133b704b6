// The bytes of a glTF file's buffers and buffer views. Internal to the importer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "client/importer/file_scene.h"
#include "client/importer/gltf/container.h"
#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

/// Reads a buffer when it is first needed, so that one which nothing needs may be missing. All
/// arguments of the constructor must outlive this object.
class Buffers {
 public:
  Buffers(const Document& document, const Container& container, const FileSource& files);

  struct View {
    std::string_view bytes;
    std::uint64_t stride = 0;  ///< 0: elements are tightly packed
  };
  /// A buffer view, decompressed if EXT_meshopt_compression is applied to it. Valid as long as this
  /// object. Refuses bytes that the buffer or the file does not have. `by`: who names it.
  View view(std::uint64_t index, std::string_view by);

 private:
  std::string_view buffer(std::uint64_t index, std::string_view by);
  std::string_view read(const Item& item, std::uint64_t index);
  std::string_view part(const Item& item);
  std::string_view decompressed(std::uint64_t index, const Item& view, const Item& compressed);

  const Document& document_;
  const Container& container_;
  const FileSource& files_;
  std::unordered_map<std::uint64_t, std::string_view> buffers_;
  std::unordered_map<std::uint64_t, std::string> decoded_;       // by buffer: that of a data URI
  std::unordered_map<std::uint64_t, std::string> decompressed_;  // by buffer view
};

}  // namespace sightline::client::importer::gltf
