// A mesh as the bytes that are uploaded, and the digest of those bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "client/types.h"

namespace sightline::client {

/// Refers to the arrays without copying them. They must outlive it.
class MeshBlob {
 public:
  /// `copy_number` (0, 1, 2, ...) distinguishes meshes of equal content, if a scene shall have
  /// several.
  MeshBlob(std::span<const Vertex> vertices, std::span<const Face> faces,
           std::uint32_t copy_number = 0);

  std::uint64_t size() const { return header_.size() + positions_.size() + indices_.size(); }

  /// Copies out.size() bytes, beginning at `offset`. Asserts that they exist.
  void copy(std::uint64_t offset, std::span<std::byte> out) const;

  /// "sha256:<64 hex digits>/<size>". Reads all bytes.
  std::string digest() const;

 private:
  std::array<std::byte, 24> header_;
  std::span<const std::byte> positions_;
  std::span<const std::byte> indices_;
};

/// Called with the number of the mesh's bytes that the server has.
using UploadProgress = std::function<void(std::uint64_t bytes)>;

}  // namespace sightline::client
