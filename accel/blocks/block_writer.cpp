#include "accel/blocks/block_writer.h"

#include <cstring>

#include "accel/blocks/block.h"
#include "accel/blocks/frame.h"

namespace sightline::accel::blocks {

const std::uint32_t* write_block(const geometry::MeshView& mesh, const geometry::Vec3f& center,
                                 const std::uint32_t* ids, std::size_t count,
                                 const SharedVertices& shared, Arena& arena) {
  const std::size_t vertices = shared.count, words = Block::words(count, vertices);
  std::uint32_t* const block = arena.words(words);
  block[0] = static_cast<std::uint32_t>(count | vertices << 8);
  auto* to = reinterpret_cast<float*>(block + 1);
  for (std::size_t i = 0; i < vertices; ++i) {
    const geometry::Vec3f& v = mesh.vertices.data()[shared.vertices[i]];
    to[i] = relative(v.x, center.x);
    to[vertices + i] = relative(v.y, center.y);
    to[2 * vertices + i] = relative(v.z, center.z);
  }
  std::uint32_t* at = block + 1 + 3 * vertices;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < Block::corner_words(count); ++i)
      std::memcpy(at++, shared.corners[k] + sizeof(std::uint32_t) * i, sizeof(std::uint32_t));
  }
  for (std::size_t i = 0; i < count; ++i) *at++ = ids[i];
  while (at < block + words) *at++ = 0;
  return block;
}

}  // namespace sightline::accel::blocks
