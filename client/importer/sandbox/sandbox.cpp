// Forks, opens files for the child, keeps its limits up to date, and says what it died of.
#include "client/importer/sandbox/sandbox.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

#include "client/importer/sandbox/channel.h"
#include "client/importer/sandbox/confine.h"
#include "client/importer/sandbox/folder.h"
#include "client/importer/sandbox/stuck.h"

namespace sightline::client::importer::sandbox {
namespace {

using Clock = std::chrono::steady_clock;

// A child that waits for something that never comes uses no processor time. On a busy machine it
// may take much longer than that.
constexpr int kWallPerProcessorTime = 8;

// How often a silent child is looked at, and how many children are replaced if they are stuck.
constexpr std::chrono::milliseconds kLookInterval{100};
constexpr int kMostStuck = 3;

// What this process holds already counts for a child that is forked from it.
std::uint64_t data_bytes() {
  std::uint64_t size = 0, resident = 0, shared = 0, text = 0, library = 0, data = 0;
  std::FILE* const file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  const int read = std::fscanf(file, "%lu %lu %lu %lu %lu %lu", &size, &resident, &shared, &text,
                               &library, &data);
  std::fclose(file);
  return read == 6 ? data * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

void set_limit(pid_t process, __rlimit_resource resource, std::uint64_t value) {
  rlimit limit{};
  if (::prlimit(process, resource, nullptr, &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  ::prlimit(process, resource, &limit, nullptr);
}

[[noreturn]] void run_child(pid_t parent, int channel, int result,
                            const std::function<void(Inside&)>& work) {
  if (const char* const why = confine(parent, channel, result)) {
    (void)send(kChannel, Request::of(Request::Kind::kUnconfined, why));
    ::_exit(1);
  }
  std::set_new_handler([] {
    (void)send(kChannel, Request::of(Request::Kind::kOutOfMemory));
    ::_exit(1);
  });
  try {
    Inside inside;
    work(inside);
  } catch (...) {  // the parent sees a death without a result
  }
  ::_exit(1);
}

class Child {
 public:
  Child(const std::filesystem::path& file, SceneFolder folder, const Limits& limits)
      : file_(file), folder_(std::move(folder)), limits_(limits), inherited_(data_bytes()) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { end(); }

  Status start(const std::function<void(Inside&)>& work) {
    result_ = FileHandle(::memfd_create("sightline-import", MFD_CLOEXEC));
    auto channel = open_channel();
    if (!result_ || !channel) return failed(std::generic_category().message(errno));
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ < 0) return failed(std::generic_category().message(errno));
    if (process_ == 0) run_child(parent, channel->theirs.get(), result_.get(), work);
    channel_ = std::move(channel->ours);
    update_limits();
    return {};
  }

  /// Serves the child until it is done or dead or, if it may be replaced, stuck.
  void serve(const std::function<void(double)>& progress, bool replaceable) {
    replaceable_ = replaceable;
    Request request;
    while (wait_for_request() && receive(channel_.get(), request)) {
      if (request.kind == Request::Kind::kProgress) {
        if (progress && request.part >= 0 && request.part <= 1) progress(request.part);
      } else if (request.kind == Request::Kind::kOpen) {
        if (!answer(std::string(request.message()))) break;
      } else {
        last_ = request;
        break;
      }
    }
    status_ = end();
    const bool yielded = status_ && WIFSIGNALED(*status_) && WTERMSIG(*status_) == SIGSYS;
    stuck_ = stuck_ || (replaceable_ && yielded);
  }

  bool stuck() const { return stuck_; }

  Result<Outcome> outcome() const {
    if (last_ && last_->kind == Request::Kind::kDone) return result(last_->bytes);
    if (last_ && last_->kind == Request::Kind::kUnconfined) {
      return Error{Code::kUnimplemented,
                   fmt::format("{}: not read, because this system cannot confine the process that "
                               "would read it: {}",
                               file_.string(), last_->message()),
                   {}};
    }
    if (last_ && last_->kind == Request::Kind::kOutOfMemory) {
      return failed(fmt::format("reading it takes more than the {} MiB that a file of its size may",
                                memory() >> 20U));
    }
    return failed(death());
  }

 private:
  Error failed(std::string why) const {
    if (!folder_.refusals().empty()) why += "; " + folder_.refusals().front();
    return file_error(file_, why);
  }

  std::uint64_t memory() const { return limits_.memory.of(folder_.bytes()); }
  std::uint64_t seconds() const { return 1 + limits_.time_us.of(folder_.bytes()) / 1'000'000; }

  void update_limits() const {
    set_limit(process_, RLIMIT_DATA, inherited_ + memory());
    set_limit(process_, RLIMIT_FSIZE, memory());
    set_limit(process_, RLIMIT_CPU, seconds());
  }

  bool answer(const std::string& name) {
    const std::optional<OpenedFile> file = folder_.open_file(name);
    update_limits();
    const Reply reply = file ? Reply{file->bytes, file->number} : Reply{};
    return send(channel_.get(), reply, file ? file->handle.get() : -1);
  }

  bool wait_for_request() {
    const auto end = started_ + std::chrono::seconds(kWallPerProcessorTime * seconds());
    StuckWatch watch;
    for (;;) {
      const auto rest = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
      const auto wait = std::clamp(rest, rest.zero(), kLookInterval);
      pollfd ready{channel_.get(), POLLIN, 0};
      const int count = ::poll(&ready, 1, static_cast<int>(wait.count()));
      if (count > 0) return true;
      if (count < 0 && errno == EINTR) continue;
      out_of_time_ = count < 0 || rest <= rest.zero();
      stuck_ = !out_of_time_ && replaceable_ && watch.is_stuck(process_);
      if (out_of_time_ || stuck_) return false;
    }
  }

  /// Returns the wait status of the child, or nothing if another thread waited for it.
  std::optional<int> end() {
    if (process_ <= 0) return {};
    channel_.close();
    const bool is_done = last_ && last_->kind == Request::Kind::kDone;
    if (out_of_time_ || stuck_ || is_done) ::kill(process_, SIGKILL);
    int status = 0;
    pid_t ended = 0;
    do {
      ended = ::waitpid(process_, &status, 0);
    } while (ended < 0 && errno == EINTR);
    const bool known = ended == std::exchange(process_, 0);
    return known ? std::optional(status) : std::nullopt;
  }

  std::string death() const {
    if (out_of_time_ || (status_ && WIFSIGNALED(*status_) && WTERMSIG(*status_) == SIGXCPU)) {
      return fmt::format("reading it takes more than the {} s that a file of its size may",
                         seconds());
    }
    if (status_ && WIFSIGNALED(*status_)) {
      return fmt::format("damaged, or too much for Assimp, which died of it ({})",
                         ::sigdescr_np(WTERMSIG(*status_)));
    }
    return "damaged, or too much for Assimp, which ended";
  }

  // The child is dead, so the bytes do not change any more.
  Result<Outcome> result(std::uint64_t bytes) const {
    struct stat status {};
    if (::fstat(result_.get(), &status) != 0 || static_cast<std::uint64_t>(status.st_size) != bytes)
      return failed("the process that read it left no result");
    return Outcome{MappedBytes(result_.get(), bytes), folder_.refusals()};
  }

  std::filesystem::path file_;
  SceneFolder folder_;
  Limits limits_;
  std::uint64_t inherited_;
  FileHandle result_, channel_;
  pid_t process_ = 0;
  Clock::time_point started_ = Clock::now();
  std::optional<Request> last_;
  std::optional<int> status_;
  bool out_of_time_ = false;
  bool replaceable_ = false, stuck_ = false;
};

}  // namespace

MappedBytes::MappedBytes(int file, std::size_t size) : size_(size) {
  if (size == 0) return;
  void* const bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file, 0);
  if (bytes == MAP_FAILED) throw std::bad_alloc();
  bytes_ = static_cast<const std::byte*>(bytes);
}

MappedBytes::~MappedBytes() {
  if (bytes_ != nullptr) ::munmap(const_cast<std::byte*>(bytes_), size_);
}

Result<Outcome> run(const std::filesystem::path& file, const Limits& limits,
                    const std::function<void(double)>& progress,
                    const std::function<void(Inside&)>& work) {
  for (int stuck = 0;; ++stuck) {
    auto folder = SceneFolder::open(file, limits.memory);
    if (!folder) return folder.error();
    Child child(file, *std::move(folder), limits);
    if (const Status started = child.start(work); !started) return started.error();
    child.serve(progress, stuck < kMostStuck);
    if (!child.stuck()) return child.outcome();
  }
}

}  // namespace sightline::client::importer::sandbox
