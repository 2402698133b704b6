// A mesh as a blob: the digest that names it, and its bytes, read as they arrive.
#include "server/blobs/mesh_blob.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <new>
#include <type_traits>

#include "server/exec/rpc_status.h"

namespace sightline::server::blobs {
namespace {

constexpr std::string_view kPrefix = "sha256:";

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

bool parse_sum(std::string_view hex, Sha256Sum& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const int high = hex_digit(hex[2 * i]);
    const int low = hex_digit(hex[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    sum[i] = static_cast<std::uint8_t>(high * 16 + low);
  }
  return true;
}

bool parse_size(std::string_view digits, std::uint64_t& size) {
  if (digits.empty() || (digits.front() == '0' && digits.size() > 1)) return false;
  const char* end = digits.data() + digits.size();
  const auto [parsed_to, error] = std::from_chars(digits.data(), end, size);
  return error == std::errc{} && parsed_to == end;
}

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

}  // namespace

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) {
    throw std::bad_alloc();
  }
}

void Sha256::update(std::span<const std::byte> bytes) {
  EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size());
}

Sha256Sum Sha256::finish() {
  Sha256Sum sum{};
  EVP_DigestFinal_ex(context_.get(), sum.data(), nullptr);
  return sum;
}

Result<BlobDigest> BlobDigest::parse(std::string_view text) {
  constexpr std::size_t kHex = 2 * std::tuple_size_v<Sha256Sum>;
  BlobDigest digest;
  const bool good = text.size() > kPrefix.size() + kHex && text.starts_with(kPrefix) &&
                    text[kPrefix.size() + kHex] == '/' &&
                    parse_sum(text.substr(kPrefix.size(), kHex), digest.sum) &&
                    parse_size(text.substr(kPrefix.size() + kHex + 1), digest.size);
  if (good) return digest;
  return Error{Code::kInvalidArgument,
               fmt::format("{} is not a digest of the form sha256:<64 hex digits>/<size>",
                           exec::quote(text)),
               "BAD_DIGEST"};
}

std::string BlobDigest::text() const {
  std::string out(kPrefix);
  for (const std::uint8_t byte : sum) out += fmt::format("{:02x}", byte);
  return out + fmt::format("/{}", size);
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
  vertices_.reserve(vertices);
  faces_.reserve(faces);
  return {};
}

Result<std::shared_ptr<const scenegraph::model::Mesh>> MeshBlobReader::finish() {
  if (received_ != size_ || size_ < kMeshBlobHeader) {
    return bad_blob(fmt::format("{} bytes arrived of a blob of {}", received_, size_));
  }
  return scenegraph::model::Mesh::make(std::move(vertices_), std::move(faces_));
}

}  // namespace sightline::server::blobs
