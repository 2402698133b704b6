// Reads the directory at the end of an archive; checks every length in it.
#include "client/cli/files/zip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::uint32_t kLocalHeader = 0x04034b50, kDirectoryHeader = 0x02014b50,
                        kDirectoryEnd = 0x06054b50;
constexpr std::size_t kLocalBytes = 30, kDirectoryBytes = 46, kEndBytes = 22;
constexpr std::size_t kLongestComment = 0xffff;
constexpr std::uint64_t kIn64 = 0xffffffff;  // a size or offset that is in the extra field
constexpr std::uint16_t kExtra64 = 1;
constexpr std::uint16_t kStored = 0, kDeflated = 8;
// Deflate packs no better than 1032 to 1.
constexpr std::uint64_t kBestRatio = 1032;

Error broken() { return local_error(".npz archive is cut off or broken"); }

class ArchiveBytes {
 public:
  explicit ArchiveBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  std::optional<T> at(std::uint64_t offset) const {
    if (offset > bytes_.size() || bytes_.size() - offset < sizeof(T)) return {};
    T value;
    std::memcpy(&value, bytes_.data() + offset, sizeof(T));
    return value;
  }

  std::optional<std::span<const std::byte>> part(std::uint64_t offset, std::uint64_t size) const {
    if (offset > bytes_.size() || bytes_.size() - offset < size) return {};
    return bytes_.subspan(offset, size);
  }

  std::uint64_t size() const { return bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
};

struct Entry {
  std::string name;
  std::uint16_t method = 0;
  std::uint64_t packed = 0, size = 0, offset = 0;
  std::uint64_t next = 0;  // offset of the next directory entry
};

std::optional<std::uint64_t> find_end(const ArchiveBytes& archive) {
  if (archive.size() < kEndBytes) return {};
  const std::uint64_t last = archive.size() - kEndBytes;
  for (std::uint64_t back = 0; back <= std::min<std::uint64_t>(last, kLongestComment); ++back) {
    if (archive.at<std::uint32_t>(last - back) == kDirectoryEnd) return last - back;
  }
  return {};
}

// Reads the numbers that did not fit 32 bits, in the order of the format.
bool read_extra64(const ArchiveBytes& archive, std::uint64_t at, std::uint64_t end, Entry& entry) {
  while (at + 4 <= end) {
    const auto tag = archive.at<std::uint16_t>(at), bytes = archive.at<std::uint16_t>(at + 2);
    if (!tag || !bytes) return false;
    if (*tag == kExtra64) {
      std::uint64_t value_at = at + 4;
      for (std::uint64_t* const value : {&entry.size, &entry.packed, &entry.offset}) {
        if (*value != kIn64) continue;
        const auto number = archive.at<std::uint64_t>(value_at);
        if (!number || value_at + 8 > at + 4 + *bytes) return false;
        *value = *number;
        value_at += 8;
      }
    }
    at += 4 + std::uint64_t{*bytes};
  }
  return true;
}

std::optional<Entry> read_entry(const ArchiveBytes& archive, std::uint64_t at) {
  const auto header = archive.part(at, kDirectoryBytes);
  if (!header || archive.at<std::uint32_t>(at) != kDirectoryHeader) return {};
  Entry entry;
  entry.method = *archive.at<std::uint16_t>(at + 10);
  entry.packed = *archive.at<std::uint32_t>(at + 20);
  entry.size = *archive.at<std::uint32_t>(at + 24);
  entry.offset = *archive.at<std::uint32_t>(at + 42);
  const std::uint64_t name = *archive.at<std::uint16_t>(at + 28),
                      extra = *archive.at<std::uint16_t>(at + 30),
                      comment = *archive.at<std::uint16_t>(at + 32);
  const auto text = archive.part(at + kDirectoryBytes, name);
  if (!text) return {};
  entry.name.assign(reinterpret_cast<const char*>(text->data()), text->size());
  const std::uint64_t extra_at = at + kDirectoryBytes + name;
  if (!read_extra64(archive, extra_at, extra_at + extra, entry)) return {};
  entry.next = extra_at + extra + comment;
  return entry;
}

std::optional<std::vector<std::byte>> inflate_all(std::span<const std::byte> packed,
                                                  std::uint64_t size) {
  constexpr auto kMost = std::numeric_limits<uInt>::max();
  if (packed.size() > kMost || size > kMost || size > kBestRatio * (packed.size() + 1)) return {};
  std::vector<std::byte> out(size);
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  // zlib only reads what next_in names.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::byte none{};
  stream.next_out = reinterpret_cast<Bytef*>(out.empty() ? &none : out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = inflate(&stream, Z_FINISH);
  const bool is_whole = result == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  if (!is_whole) return {};
  return out;
}

Result<std::vector<std::byte>> unpack(const ArchiveBytes& archive, const Entry& entry) {
  const auto name = archive.at<std::uint16_t>(entry.offset + 26);
  const auto extra = archive.at<std::uint16_t>(entry.offset + 28);
  if (archive.at<std::uint32_t>(entry.offset) != kLocalHeader || !name || !extra) return broken();
  const auto packed = archive.part(
      entry.offset + kLocalBytes + std::uint64_t{*name} + std::uint64_t{*extra}, entry.packed);
  if (!packed) return broken();
  if (entry.method == kStored) return std::vector(packed->begin(), packed->end());
  if (entry.method != kDeflated) {
    return local_error(
        fmt::format("{} is packed by method {}, deflate is known", entry.name, entry.method));
  }
  auto unpacked = inflate_all(*packed, entry.size);
  if (!unpacked) return broken();
  return *std::move(unpacked);
}

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// What a local header and an entry of the directory have in common.
void put_common(std::string& out, const ZipEntry& entry, std::uint32_t checksum) {
  constexpr std::uint16_t kFirstDay = 0x21;  // 1980-01-01: the same file for the same hits
  put<std::uint16_t>(out, 20);               // version of the format
  put<std::uint16_t>(out, 0);                // flags
  put<std::uint16_t>(out, kStored);
  put<std::uint16_t>(out, 0);  // time
  put<std::uint16_t>(out, kFirstDay);
  put<std::uint32_t>(out, checksum);
  put<std::uint32_t>(out, static_cast<std::uint32_t>(entry.bytes.size()));
  put<std::uint32_t>(out, static_cast<std::uint32_t>(entry.bytes.size()));
  put<std::uint16_t>(out, static_cast<std::uint16_t>(entry.name.size()));
  put<std::uint16_t>(out, 0);  // extra field
}

}  // namespace

Result<std::map<std::string, std::vector<std::byte>>> unzip(std::span<const std::byte> archive) {
  const ArchiveBytes bytes(archive);
  const auto end = find_end(bytes);
  if (!end) return broken();
  const std::uint16_t count = *bytes.at<std::uint16_t>(*end + 10);
  std::uint64_t at = *bytes.at<std::uint32_t>(*end + 16);
  std::map<std::string, std::vector<std::byte>> files;
  for (std::uint16_t i = 0; i < count; ++i) {
    const auto entry = read_entry(bytes, at);
    if (!entry) return broken();
    auto content = unpack(bytes, *entry);
    if (!content) return content.error();
    files[entry->name] = *std::move(content);
    at = entry->next;
  }
  return files;
}

Result<std::string> zip(std::span<const ZipEntry> entries) {
  std::string archive, directory;
  for (const ZipEntry& entry : entries) {
    const std::uint64_t offset = archive.size();
    if (offset + entry.bytes.size() >= kIn64) {
      return local_error("more than 4 GiB of hits do not fit .npz: write .npy");
    }
    const auto checksum = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(entry.bytes.data()), entry.bytes.size()));
    put(archive, kLocalHeader);
    put_common(archive, entry, checksum);
    archive += entry.name + entry.bytes;
    put(directory, kDirectoryHeader);
    put<std::uint16_t>(directory, 20);  // made by this version of the format
    put_common(directory, entry, checksum);
    put<std::uint16_t>(directory, 0);  // comment
    put<std::uint16_t>(directory, 0);  // disk
    put<std::uint16_t>(directory, 0);  // attributes
    put<std::uint32_t>(directory, 0);
    put<std::uint32_t>(directory, static_cast<std::uint32_t>(offset));
    directory += entry.name;
  }
  const auto count = static_cast<std::uint16_t>(entries.size());
  const auto at = static_cast<std::uint32_t>(archive.size());
  archive += directory;
  put(archive, kDirectoryEnd);
  put<std::uint32_t>(archive, 0);  // disks
  put(archive, count);
  put(archive, count);
  put<std::uint32_t>(archive, static_cast<std::uint32_t>(directory.size()));
  put(archive, at);
  put<std::uint16_t>(archive, 0);  // comment
  return archive;
}

}  // namespace sightline::client::cli::files
