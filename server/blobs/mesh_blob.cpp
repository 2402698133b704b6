// The bytes of a mesh as a blob, read as they arrive.
#include "server/blobs/mesh_blob.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sightline::server::blobs {
namespace {

static_assert(std::endian::native == std::endian::little,
              "blobs are little-endian and are copied as they are");

constexpr std::uint64_t kRow = 12;  // bytes of a position and of a face
constexpr std::array<char, 4> kMagic{'S', 'L', 'M', '1'};

Error bad_blob(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "BAD_MESH_BLOB"};
}

template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

/// Writes bytes at an offset of the array, which grows to hold them.
template <class Row>
void store(std::vector<Row>& rows, std::uint64_t offset, std::span<const std::byte> bytes) {
  static_assert(sizeof(Row) == kRow && std::is_trivially_copyable_v<Row>);
  if (bytes.empty()) return;
  rows.resize((offset + bytes.size() + kRow - 1) / kRow);
  std::memcpy(reinterpret_cast<std::byte*>(rows.data()) + offset, bytes.data(), bytes.size());
}

/// Reserves rows whose pages become resident as rows arrive: whole pages of memory that was used
/// before are given back.
template <class Row>
void reserve_untouched(std::vector<Row>& rows, std::uint64_t count) {
  rows.reserve(count);
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto address = reinterpret_cast<std::uintptr_t>(rows.data());
  const std::uintptr_t begin = (address + page - 1) / page * page;
  const std::uintptr_t end = (address + rows.capacity() * sizeof(Row)) / page * page;
  auto* const bytes = reinterpret_cast<std::byte*>(rows.data());
  if (begin < end) ::madvise(bytes + (begin - address), end - begin, MADV_DONTNEED);
}

}  // namespace

Status write_mesh_blob(const scenegraph::model::Mesh& mesh,
                       const std::function<Status(std::span<const std::byte>)>& part) {
  if (Status resident = mesh.make_resident(scenegraph::model::Reclaim::kAllowed); !resident)
    return resident;
  const accel::geometry::MeshView view = mesh.view();
  const std::uint64_t counts[2] = {view.vertices.size(), view.faces.size()};
  std::array<std::byte, kMeshBlobHeader> header{};
  std::memcpy(header.data(), kMagic.data(), kMagic.size());
  std::memcpy(&header[8], counts, sizeof(counts));
  if (Status written = part(header); !written) return written;
  if (Status written = part(std::as_bytes(view.vertices)); !written) return written;
  return part(std::as_bytes(view.faces));
}

BlobDigest digest_of(const scenegraph::model::Mesh& mesh) {
  Sha256 sum;
  BlobDigest digest;
  static_cast<void>(write_mesh_blob(mesh, [&](std::span<const std::byte> bytes) -> Status {
    sum.update(bytes);
    digest.size += bytes.size();
    return {};
  }));
  digest.sum = sum.finish();
  return digest;
}

Status MeshBlobReader::append(std::span<const std::byte> bytes) {
  if (bytes.size() > size_ - received_) {
    return bad_blob(
        fmt::format("{} bytes arrived of a blob of {}", received_ + bytes.size(), size_));
  }
  while (!bytes.empty()) {
    const bool in_header = received_ < kMeshBlobHeader;
    const std::uint64_t end = in_header                    ? kMeshBlobHeader
                              : received_ < positions_end_ ? positions_end_
                                                           : size_;
    const auto part = bytes.first(std::min<std::uint64_t>(bytes.size(), end - received_));
    if (in_header) {
      std::copy(part.begin(), part.end(), header_.begin() + static_cast<std::ptrdiff_t>(received_));
    } else if (received_ < positions_end_) {
      store(vertices_, received_ - kMeshBlobHeader, part);
    } else {
      store(faces_, received_ - positions_end_, part);
    }
    received_ += part.size();
    bytes = bytes.subspan(part.size());
    if (in_header && received_ == kMeshBlobHeader) {
      if (Status header = read_header(); !header) return header;
    }
  }
  return {};
}

Status MeshBlobReader::read_header() {
  if (std::memcmp(header_.data(), kMagic.data(), kMagic.size()) != 0) {
    return bad_blob("the blob does not begin with \"SLM1\"");
  }
  const auto vertices = load<std::uint64_t>(&header_[8]);
  const auto faces = load<std::uint64_t>(&header_[16]);
  // Compared one by one, because the sum of two counts in a wrong header may wrap around.
  const std::uint64_t rows = (size_ - kMeshBlobHeader) / kRow;
  if (vertices > rows || faces != rows - vertices || (size_ - kMeshBlobHeader) % kRow != 0) {
    return bad_blob(fmt::format("{} vertices and {} faces do not make a blob of {} bytes", vertices,
                                faces, size_));
  }
  if (faces > scenegraph::model::kMaxFacesPerMesh) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the mesh has {} faces, the limit is {}", faces,
                             scenegraph::model::kMaxFacesPerMesh),
                 "MESH_TOO_LARGE"};
  }
  positions_end_ = kMeshBlobHeader + vertices * kRow;
  reserve_untouched(vertices_, vertices);
  reserve_untouched(faces_, faces);
  return {};
}

Result<std::shared_ptr<const scenegraph::model::Mesh>> MeshBlobReader::finish(
    const accel::mesh::TreeBuilder& builder) {
  if (received_ != size_ || size_ < kMeshBlobHeader) {
    return bad_blob(fmt::format("{} bytes arrived of a blob of {}", received_, size_));
  }
  return scenegraph::model::Mesh::make(std::move(vertices_), std::move(faces_), builder);
}

}  // namespace sightline::server::blobs
