// Checks what the decoders only assert.
#include "client/importer/gltf/meshopt.h"

#include <meshoptimizer.h>

#include <cstddef>
#include <cstdint>

namespace sightline::client::importer::gltf {
namespace {

// The limit on the bytes that one byte may stand for, in all three codecs.
constexpr std::uint64_t kMostExpansion = 64;

enum class Codec : std::uint8_t { kAttributes, kTriangles, kIndices };

struct Layout {
  Codec codec = Codec::kAttributes;
  std::size_t count = 0, stride = 0;
};

Codec codec_of(const Item& item) {
  const std::string mode = item.text("mode");
  if (mode == "ATTRIBUTES") return Codec::kAttributes;
  if (mode == "TRIANGLES") return Codec::kTriangles;
  if (mode == "INDICES") return Codec::kIndices;
  refuse("{}: mode is '{}', must be ATTRIBUTES, TRIANGLES or INDICES", item.where(),
         mode.substr(0, 40));
}

Layout layout_of(const Item& item, std::string_view bytes) {
  const std::uint64_t count = item.integer("count"), stride = item.integer("byteStride");
  const Codec codec = codec_of(item);
  const bool fits = codec == Codec::kAttributes ? stride > 0 && stride <= 256 && stride % 4 == 0
                                                : stride == 2 || stride == 4;
  if (!fits) {
    refuse("{}: byteStride is {}, must be {}", item.where(), stride,
           codec == Codec::kAttributes ? "a multiple of 4 up to 256" : "2 or 4");
  }
  if (codec == Codec::kTriangles && count % 3 != 0)
    refuse("{}: count is {}, must be a multiple of 3", item.where(), count);
  if (count > kMostExpansion * bytes.size() / stride) {
    refuse("{}: {} elements of {} bytes cannot be compressed to {} bytes", item.where(), count,
           stride, bytes.size());
  }
  return {codec, static_cast<std::size_t>(count), static_cast<std::size_t>(stride)};
}

// Returns 0, or what is wrong.
int decode(const Layout& layout, std::string_view bytes, std::string& out) {
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto [codec, count, stride] = layout;
  if (codec == Codec::kAttributes)
    return meshopt_decodeVertexBuffer(out.data(), count, stride, data, bytes.size());
  if (codec == Codec::kTriangles)
    return meshopt_decodeIndexBuffer(out.data(), count, stride, data, bytes.size());
  return meshopt_decodeIndexSequence(out.data(), count, stride, data, bytes.size());
}

void filter(const Item& item, const Layout& layout, std::string& out) {
  const std::string name = item.has("filter") ? item.text("filter") : "NONE";
  if (name == "NONE") return;
  const bool is_octahedral = name == "OCTAHEDRAL", is_quaternion = name == "QUATERNION";
  if (!is_octahedral && !is_quaternion && name != "EXPONENTIAL") {
    refuse("{}: filter is '{}', must be NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL", item.where(),
           name.substr(0, 40));
  }
  const bool fits = layout.codec == Codec::kAttributes &&
                    (is_octahedral   ? layout.stride == 4 || layout.stride == 8
                     : is_quaternion ? layout.stride == 8
                                     : true);
  if (!fits) {
    refuse("{}: the filter {} is not for a byteStride of {}, or not for its mode", item.where(),
           name, layout.stride);
  }
  if (is_octahedral) {
    meshopt_decodeFilterOct(out.data(), layout.count, layout.stride);
  } else if (is_quaternion) {
    meshopt_decodeFilterQuat(out.data(), layout.count, layout.stride);
  } else {
    meshopt_decodeFilterExp(out.data(), layout.count, layout.stride);
  }
}

}  // namespace

std::string decompress_meshopt(const Item& item, std::string_view bytes) {
  const Layout layout = layout_of(item, bytes);
  std::string out(layout.count * layout.stride, '\0');
  const int error = decode(layout, bytes, out);
  if (error != 0) refuse("{}: its compressed data are damaged (code {})", item.where(), error);
  filter(item, layout, out);
  return out;
}

}  // namespace sightline::client::importer::gltf
