// Runs a function on a scene file in a child process that can do nothing but compute.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/importer/sandbox/allowance.h"
#include "client/importer/sandbox/inside.h"
#include "client/result.h"

namespace sightline::client::importer::sandbox {

/// What a child may use.
struct Limits {
  Allowance memory{.fixed = std::uint64_t{1} << 30, .per_byte = 64};  ///< bytes
  Allowance time_us{.fixed = 20'000'000, .per_byte = 4};              ///< processor time
};

/// The result of a child: whatever it wrote. It does not change any more.
class MappedBytes {
 public:
  /// Throws std::bad_alloc.
  MappedBytes(int file, std::size_t size);
  MappedBytes(MappedBytes&& other) noexcept
      : bytes_(std::exchange(other.bytes_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  MappedBytes& operator=(MappedBytes&&) = delete;
  ~MappedBytes();

  std::span<const std::byte> span() const { return {bytes_, size_}; }

 private:
  const std::byte* bytes_ = nullptr;
  std::size_t size_ = 0;
};

struct Outcome {
  MappedBytes bytes;
  std::vector<std::string> refusals;  ///< files that it asked for and did not get, and why
};

/// Forks a child, which runs `work` and must end by Inside::finish. The scene file is
/// `Inside::read(file.filename())`. `progress` is called on this thread. Errors, all with the
/// file's path: kInvalidArgument: the file cannot be read, or the child died, and of what;
/// kUnimplemented: this system cannot confine a process.
Result<Outcome> run(const std::filesystem::path& file, const Limits& limits,
                    const std::function<void(double)>& progress,
                    const std::function<void(Inside&)>& work);

}  // namespace sightline::client::importer::sandbox
