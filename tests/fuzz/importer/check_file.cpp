// A child process reads the file first, then this process.
#include "tests/fuzz/importer/check_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/importer/assimp_file.h"
#include "client/importer/read_scene.h"
#include "tests/fuzz/importer/check_imported.h"

/// Sanitizers' functions, if there is a sanitizer.
extern "C" [[gnu::weak]] void __sanitizer_set_death_callback(void (*callback)());

namespace sightline::tests {
namespace {

namespace fs = std::filesystem;

constexpr int kTimeoutMs = 5000;

/// A folder of this process, removed at its end.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("sightline-fuzz-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path put(const char* ending, std::span<const std::uint8_t> contents) const {
    fs::path file = path_ / "case";
    file.replace_extension(ending);
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(contents.data()),
              static_cast<std::streamsize>(contents.size()));
    return file;
  }

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// A crash in the child is silent, and not reported as the fuzzer's finding.
void die_quietly() {
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(nullptr);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGILL, SIGFPE, SIGALRM, SIGINT, SIGTERM})
    std::signal(signal, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  dup2(open("/dev/null", O_WRONLY | O_CLOEXEC), STDERR_FILENO);
}

/// One file, with a name that has no folder.
struct NamedFile {
  std::string name;
  std::string_view bytes;

  client::importer::FileSource source() const {
    return [this](const std::string& asked) {
      return asked == name ? std::optional(bytes) : std::nullopt;
    };
  }
};

/// Only whether this process survives matters here.
void read_by_assimp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const NamedFile file{path.filename().string(), bytes};
  try {
    (void)client::importer::AssimpFile::read(file.name, file.source()).ok();
  } catch (const std::exception&) {
  }
}

/// A process that reads the file on every request, and is replaced when it dies. Forking for each
/// file would take most of the time.
class Taster {
 public:
  explicit Taster(fs::path folder) : folder_(std::move(folder)) {}
  ~Taster() { stop(); }
  Taster(const Taster&) = delete;
  Taster& operator=(const Taster&) = delete;

  /// A child that has read many files may die of an earlier one: a fresh child decides.
  bool survives(const fs::path& file) {
    const bool is_fresh = child_ == 0;
    return try_once(file) || (!is_fresh && try_once(file));
  }

 private:
  bool try_once(const fs::path& file) {
    if (child_ == 0) start();
    const std::string name = file.filename().string() + "\n";
    char answer = 0;
    pollfd ready{answers_, POLLIN, 0};
    if (write(questions_, name.data(), name.size()) == static_cast<ssize_t>(name.size()) &&
        poll(&ready, 1, kTimeoutMs) == 1 && read(answers_, &answer, 1) == 1)
      return true;
    stop();
    return false;
  }

  void start() {
    std::signal(SIGPIPE, SIG_IGN);
    int to[2], from[2];
    if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0) std::abort();
    child_ = fork();
    if (child_ == 0) {
      close(to[1]);
      close(from[0]);
      serve(to[0], from[1]);
    }
    close(to[0]);
    close(from[1]);
    questions_ = to[1];
    answers_ = from[0];
  }

  [[noreturn]] void serve(int questions, int answers) const {
    die_quietly();
    std::string name;
    for (char c = 0; read(questions, &c, 1) == 1;) {
      if (c != '\n') {
        name += c;
        continue;
      }
      read_by_assimp(folder_ / name);
      name.clear();
      if (write(answers, "!", 1) != 1) break;
    }
    _exit(EXIT_SUCCESS);
  }

  void stop() {
    if (child_ <= 0) return;
    close(questions_);
    close(answers_);
    kill(child_, SIGKILL);
    while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
    }
    child_ = 0;
  }

  fs::path folder_;
  pid_t child_ = 0;
  int questions_ = -1, answers_ = -1;
};

/// Endings of the formats that Assimp does not read here.
constexpr std::string_view kOwn[] = {"obj", "ply", "stl", "glb", "gltf"};

FileReport import(const NamedFile& file) {
  const auto scene = client::importer::read_scene(file.name, file.source());
  if (scene) return {FileOutcome::kTaken, check_animated(*scene)};
  if (!scene.error().message.empty()) return {FileOutcome::kRefused, {}};
  return {FileOutcome::kRefused, "refused without a word"};
}

}  // namespace

const char* ending_of(std::span<const std::uint8_t> bytes) {
  static constexpr const char* kEndings[] = {"obj", "ply", "stl", "glb", "gltf",
                                             "dae", "ac",  "fbx", "ifc"};
  return kEndings[bytes.empty() ? 0 : bytes[0] % std::size(kEndings)];
}

FileReport check_file(std::span<const std::uint8_t> bytes) {
  const char* const ending = ending_of(bytes);
  static const Folder folder;
  static Taster taster(folder.path());
  if (!bytes.empty()) bytes = bytes.subspan(1);
  const fs::path path = folder.put(ending, bytes);
  const NamedFile file{path.filename().string(),
                       {reinterpret_cast<const char*>(bytes.data()), bytes.size()}};
  const bool is_read_by_assimp =
      std::find(std::begin(kOwn), std::end(kOwn), ending) == std::end(kOwn) &&
      !file.bytes.starts_with("glTF") && !file.bytes.starts_with("ply");
  if (is_read_by_assimp && !taster.survives(path)) return {FileOutcome::kAssimpDied, {}};
  return import(file);
}

}  // namespace sightline::tests
