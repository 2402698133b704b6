// Asks a confined process to read the file, and checks what it answers.
#include "client/importer/assimp_import.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "client/importer/archive.h"
#include "client/importer/check_received.h"
#include "client/importer/lattice.h"
#include "client/importer/read_scene.h"
#include "client/importer/sandbox/folder.h"
#include "client/importer/sandbox/sandbox.h"
#include "client/importer/scene_fields.h"

namespace sightline::client::importer {
namespace {

constexpr std::size_t kLongestMessage = 1000;  // bytes
constexpr double kStep = 0.01;                 // of the progress between two messages

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
template <class Scene>
struct Answer {
  std::string error;
  Scene scene;
};

template <class Archive, class Scene>
void fields(Archive& archive, Answer<Scene>& answer) {
  archive(answer.error, answer.scene);
}

template <class Scene>
using Read = Result<Scene> (*)(const std::string&, const FileSource&, const ImportOptions&,
                               const ImportProgress&);

// Runs in the confined process.
template <class Scene>
void answer(sandbox::Inside& inside, const std::string& name, const ImportOptions& options,
            bool wants_progress, Read<Scene> read) {
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
  Answer<Scene> result;
  if (auto scene = read(name, files, options, progress)) {
    result.scene = *std::move(scene);
  } else {
    result.error = scene.error().message.empty() ? "cannot be read" : scene.error().message;
  }
  const ArchiveWriter writer(inside);
  writer(result);
  inside.finish();
}

template <class Scene>
Result<Scene> import(const std::filesystem::path& file, const ImportOptions& options,
                     const ImportProgress& progress, Read<Scene> read) {
  if (const Status good = check(options); !good) return good.error();
  const std::string name = file.filename().string();
  const bool wants_progress = static_cast<bool>(progress);
  const auto outcome = sandbox::run(file, {}, progress, [&](sandbox::Inside& inside) {
    answer(inside, name, options, wants_progress, read);
  });
  if (!outcome) return outcome.error();
  Answer<Scene> received;
  ArchiveReader reader(outcome->bytes.span());
  reader(received);
  if (!received.error.empty()) return in_file(file, std::move(received.error), outcome->refusals);
  Status good = check_received(received.scene);
  if (!reader.is_complete()) good = import_error("it is incomplete");
  if (!good) {
    return in_file(file, "the process that read it left a damaged result: " + good.error().message,
                   outcome->refusals);
  }
  std::vector<std::string>& warnings = warnings_of(received.scene);
  warnings.insert(warnings.begin(), outcome->refusals.begin(), outcome->refusals.end());
  for (std::string& warning : warnings) warning = fmt::format("{}: {}", file.string(), warning);
  return std::move(received.scene);
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

Result<ImportedScene> import_unrebased(const std::filesystem::path& file,
                                       const ImportOptions& options,
                                       const ImportProgress& progress) {
  return import(file, options, progress, read_scene);
}

Result<ImportedScene> import_scene(const std::filesystem::path& file, const ImportOptions& options,
                                   const ImportProgress& progress) {
  auto scene = import_unrebased(file, options, progress);
  if (scene) rebase(*scene);
  return scene;
}

Result<AnimatedScene> import_animated_scene(const std::filesystem::path& file,
                                            const ImportOptions& options,
                                            const ImportProgress& progress) {
  return import(file, options, progress, read_animated_scene);
}

}  // namespace sightline::client::importer
