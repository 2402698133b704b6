// Files are in memory as a whole.
#include "client/importer/assimp_files.h"

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace sightline::client::importer {
namespace {

class Stream final : public Assimp::IOStream {
 public:
  explicit Stream(std::string_view bytes) : bytes_(bytes) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (bytes_.size() - at_) / size);
    if (whole > 0) std::memcpy(to, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }

  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  void Flush() override {}

  // Offsets back from the current position arrive as huge numbers, and wrap.
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t from = origin == aiOrigin_SET   ? 0
                             : origin == aiOrigin_CUR ? at_
                                                      : bytes_.size();
    const std::size_t to = from + offset;
    if (to > bytes_.size()) return aiReturn_FAILURE;
    at_ = to;
    return aiReturn_SUCCESS;
  }

  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

class Files final : public Assimp::IOSystem {
 public:
  explicit Files(const FileSource& source) : source_(source) {}

  bool Exists(const char* name) const override { return find(name).has_value(); }
  char getOsSeparator() const override { return '/'; }

  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (std::string_view(mode).find_first_of("wa+") != std::string_view::npos) return nullptr;
    const auto bytes = find(name);
    return bytes ? std::make_unique<Stream>(*bytes).release() : nullptr;
  }

  void Close(Assimp::IOStream* stream) override {
    const std::unique_ptr<Assimp::IOStream> owned(stream);
  }

  bool CreateDirectory(const std::string&) override { return false; }
  bool ChangeDirectory(const std::string&) override { return false; }
  bool DeleteFile(const std::string&) override { return false; }

 private:
  // Assimp asks for the same file several times.
  std::optional<std::string_view> find(const std::string& name) const {
    const auto known = known_.find(name);
    if (known != known_.end()) return known->second;
    return known_.emplace(name, source_(name)).first->second;
  }

  const FileSource& source_;
  mutable std::map<std::string, std::optional<std::string_view>> known_;
};

}  // namespace

std::unique_ptr<Assimp::IOSystem> assimp_files(const FileSource& files) {
  return std::make_unique<Files>(files);
}

}  // namespace sightline::client::importer
