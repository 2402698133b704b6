// The layout of mesh blobs (proto/sightline/v1/blob.proto) and their digests.
#include "client/mesh_blob.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "client/sha256.h"

namespace sightline::client {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are sent as they are in memory");
static_assert(sizeof(Vertex) == 12 && sizeof(Face) == 12);

std::array<std::byte, 24> make_header(std::uint32_t copy_number, std::uint64_t vertices,
                                      std::uint64_t faces) {
  std::array<std::byte, 24> header{};
  std::memcpy(header.data(), "SLM1", 4);
  std::memcpy(header.data() + 4, &copy_number, 4);
  std::memcpy(header.data() + 8, &vertices, 8);
  std::memcpy(header.data() + 16, &faces, 8);
  return header;
}

}  // namespace

MeshBlob::MeshBlob(std::span<const Vertex> vertices, std::span<const Face> faces,
                   std::uint32_t copy_number)
    : header_(make_header(copy_number, vertices.size(), faces.size())),
      positions_(std::as_bytes(vertices)),
      indices_(std::as_bytes(faces)) {}

void MeshBlob::copy(std::uint64_t offset, std::span<std::byte> out) const {
  assert(offset + out.size() <= size());
  for (const std::span<const std::byte> part :
       {std::span<const std::byte>(header_), positions_, indices_}) {
    if (offset >= part.size()) {
      offset -= part.size();
      continue;
    }
    const std::size_t n = std::min<std::size_t>(part.size() - offset, out.size());
    std::copy_n(part.begin() + static_cast<std::ptrdiff_t>(offset), n, out.begin());
    out = out.subspan(n);
    offset = 0;
  }
}

std::string MeshBlob::digest() const {
  Sha256 sha;
  sha.add(header_);
  sha.add(positions_);
  sha.add(indices_);
  return fmt::format("sha256:{}/{}", sha.hex(), size());
}

}  // namespace sightline::client
