// Asks a confined process to read the file, and checks what it answers.
#include "client/importer/assimp_import.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/importer/archive.h"
#include "client/importer/check_received.h"
#include "client/importer/read_scene.h"
#include "client/importer/sandbox/folder.h"
#include "client/importer/sandbox/sandbox.h"
#include "client/importer/scene_fields.h"

namespace sightline::client::importer {
namespace {

constexpr std::size_t kLongestMessage = 1000;  // bytes
constexpr double kStep = 0.01;                 // progress between two messages

Error in_file(const std::filesystem::path& file, std::string message,
              const std::vector<std::string>& refusals) {
  if (message.size() > kLongestMessage) message.resize(kLongestMessage);
  if (!refusals.empty()) message += "; " + refusals.front();  // Assimp tries names like it, too
  return import_error(fmt::format("{}: {}", file.string(), message));
}

Status check(const ImportOptions& options) {
  const double unit = options.meters_per_unit.value_or(1);
  if (unit > 0 && std::isfinite(unit)) return {};
  return import_error(fmt::format("meters per unit is {}, must be above 0", unit));
}

// A scene, or a message that says why there is none.
struct Answer {
  std::string error;
  AnimatedScene scene;
};

template <class Archive>
void fields(Archive& archive, Answer& answer) {
  archive(answer.error, answer.scene);
}

// Runs in the confined process.
void answer(sandbox::Inside& inside, const std::string& name, const ImportOptions& options,
            bool wants_progress) {
  ImportProgress progress;
  double shown = 0;
  if (wants_progress) {
    progress = [&](double part) {
      if (part - shown < kStep) return;
      shown = part;
      inside.progress(part);
    };
  }
  const FileSource files = [&](const std::string& asked) { return inside.read(asked); };
  Answer result;
  if (auto scene = read_scene(name, files, options, progress)) {
    result.scene = *std::move(scene);
  } else {
    result.error = scene.error().message.empty() ? "cannot be read" : scene.error().message;
  }
  const ArchiveWriter writer(inside);
  writer(result);
  inside.finish();
}

// The warnings about a file of this path, those of refused files first.
std::vector<Warning> warnings_of(const std::filesystem::path& file,
                                 const std::vector<std::string>& refusals,
                                 std::vector<Warning> of_scene) {
  std::vector<Warning> out;
  out.reserve(refusals.size() + of_scene.size());
  for (const std::string& refusal : refusals) {
    out.push_back({.kind = "file_not_read", .message = refusal});
  }
  std::move(of_scene.begin(), of_scene.end(), std::back_inserter(out));
  for (Warning& warning : out) {
    if (!warning.is_note) warning.message = fmt::format("{}: {}", file.string(), warning.message);
  }
  return out;
}

std::uint64_t memory_of_machine() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

Status check_readable(const std::filesystem::path& file) {
  const auto opened = sandbox::open_regular(file);
  if (!opened) return opened.error();
  std::error_code ignored;
  const std::uint64_t bytes = std::filesystem::file_size(file, ignored);
  if (ignored || bytes <= memory_of_machine()) return {};
  return Error{
      Code::kResourceExhausted,
      fmt::format("{}: {} bytes, more than the memory of this machine", file.string(), bytes),
      {}};
}

Result<ImportedScene> import_scene(const std::filesystem::path& file, const ImportOptions& options,
                                   const ImportProgress& progress) {
  auto animated = import_animated_scene(file, options, progress);
  if (!animated) return animated.error();
  return std::move(animated->scene);
}

Result<AnimatedScene> import_animated_scene(const std::filesystem::path& file,
                                            const ImportOptions& options,
                                            const ImportProgress& progress) {
  if (const Status good = check(options); !good) return good.error();
  const std::string name = file.filename().string();
  const bool wants_progress = static_cast<bool>(progress);
  const auto outcome = sandbox::run(file, {}, progress, [&](sandbox::Inside& inside) {
    answer(inside, name, options, wants_progress);
  });
  if (!outcome) return outcome.error();
  Answer received;
  ArchiveReader reader(outcome->bytes.span());
  reader(received);
  if (!received.error.empty()) return in_file(file, std::move(received.error), outcome->refusals);
  Status good = check_received(received.scene);
  if (!reader.is_complete()) good = import_error("it is incomplete");
  if (!good) {
    return in_file(file, "the process that read it left a damaged result: " + good.error().message,
                   outcome->refusals);
  }
  std::vector<Warning>& warnings = received.scene.scene.warnings;
  warnings = warnings_of(file, outcome->refusals, std::move(warnings));
  return std::move(received.scene);
}

}  // namespace sightline::client::importer
