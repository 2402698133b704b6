// A confined process can compute and nothing else, and its death is an error with a cause.
#include "client/importer/sandbox/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer::sandbox {
namespace {

using tests::TempDir;

Result<Outcome> run_on(const std::string& file, const std::function<void(Inside&)>& work,
                       const Limits& limits = {}) {
  return run(file, limits, {}, work);
}

std::string text_of(const Outcome& outcome) {
  return {reinterpret_cast<const char*>(outcome.bytes.span().data()), outcome.bytes.span().size()};
}

std::string error_of(const Result<Outcome>& outcome) {
  return outcome ? "" : outcome.error().message;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Sandbox, HandsOverFilesProgressAndTheResult) {
  const TempDir dir;
  dir.write("b.bin", "second");
  const std::string file = dir.write("a.obj", "first");
  std::vector<double> parts;
  const auto outcome = run(
      file, {}, [&](double part) { parts.push_back(part); },
      [](Inside& inside) {
        inside.progress(0.25);
        for (const char* name : {"a.obj", "b.bin", "none"}) {
          const auto bytes = inside.read(name);
          const std::string text = bytes ? std::string(*bytes) + ";" : "nothing;";
          inside.write(text.data(), text.size());
        }
        inside.progress(0.75);
        inside.finish();
      });
  ASSERT_TRUE(outcome) << error_of(outcome);
  EXPECT_EQ(text_of(*outcome), "first;second;nothing;");
  EXPECT_EQ(parts, (std::vector<double>{0.25, 0.75}));
}

// Returns 1 for each call that succeeded.
std::array<char, 10> try_what_is_forbidden(const std::string& file) {
  std::array<char, 10> done{};
  done[0] = ::open(file.c_str(), O_RDONLY) >= 0 ? 1 : 0;
  done[1] = ::open("/tmp/sightline-sandbox-test", O_CREAT | O_WRONLY, 0600) >= 0 ? 1 : 0;
  done[2] = ::socket(AF_INET, SOCK_STREAM, 0) >= 0 ? 1 : 0;
  done[3] = ::socket(AF_UNIX, SOCK_STREAM, 0) >= 0 ? 1 : 0;
  done[4] = ::fork() >= 0 ? 1 : 0;
  done[5] = ::kill(::getppid(), 0) == 0 ? 1 : 0;
  done[6] = ::ptrace(PTRACE_ATTACH, 1, nullptr, nullptr) == 0 ? 1 : 0;
  const rlimit more{RLIM_INFINITY, RLIM_INFINITY};
  done[7] = ::setrlimit(RLIMIT_CPU, &more) == 0 ? 1 : 0;
  done[8] = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS,
                   -1, 0) != MAP_FAILED
                ? 1
                : 0;
  char* const arguments[] = {nullptr};
  ::execv("/bin/true", arguments);
  done[9] = errno == EPERM ? 0 : 1;
  return done;
}

TEST(Sandbox, AllowsNoFileNoSocketNoProcess) {
  const TempDir dir;
  const std::string file = dir.write("a.obj", "first");
  const auto outcome = run_on(file, [&](Inside& inside) {
    const auto done = try_what_is_forbidden(file);
    inside.write(done.data(), done.size());
    inside.finish();
  });
  ASSERT_TRUE(outcome) << error_of(outcome);
  EXPECT_EQ(text_of(*outcome), std::string(10, '\0'));
}

TEST(Sandbox, InheritsNoDescriptor) {
  const TempDir dir;
  const std::string secret = dir.write("secret", "secret");
  const int inherited = ::open(secret.c_str(), O_RDONLY);
  const auto outcome = run_on(dir.write("a.obj", ""), [&](Inside& inside) {
    for (int descriptor = 0; descriptor <= inherited + 10; ++descriptor) {
      char byte = 0;
      if (::lseek(descriptor, 0, SEEK_SET) == 0 && ::read(descriptor, &byte, 1) == 1)
        inside.write(&byte, 1);
    }
    inside.finish();
  });
  ::close(inherited);
  ASSERT_TRUE(outcome) << error_of(outcome);
  EXPECT_EQ(text_of(*outcome), "");
}

TEST(Sandbox, SaysWhatTheChildDiedOf) {
  const TempDir dir;
  const std::string file = dir.write("a.obj", "first");
  const auto crash = run_on(file, [](Inside&) { ::raise(SIGKILL); });
  EXPECT_FALSE(crash);
  const auto abort = run_on(file, [](Inside&) { std::abort(); });
  EXPECT_TRUE(holds(error_of(abort), file + ": damaged, or too much for Assimp"))
      << error_of(abort);
  EXPECT_EQ(abort.error().code, Code::kInvalidArgument);
  const auto thrown = run_on(file, [](Inside&) { throw 7; });
  EXPECT_TRUE(holds(error_of(thrown), "which ended")) << error_of(thrown);
  const auto silent = run_on(file, [](Inside&) { ::_exit(0); });
  EXPECT_TRUE(holds(error_of(silent), "which ended")) << error_of(silent);
}

TEST(Sandbox, LimitsProcessorTime) {
  const TempDir dir;
  const auto outcome = run_on(dir.write("a.obj", ""),
                              [](Inside&) {
                                volatile bool forever = true;
                                while (forever) {
                                }
                              },
                              {.time_us = {.fixed = 1, .per_byte = 1}});
  EXPECT_TRUE(holds(error_of(outcome), "takes more than the 1 s")) << error_of(outcome);
}

// A thread of the parent may hold a lock of the allocator at the moment of the fork.
TEST(Sandbox, ReplacesAChildThatWaitsForALockOfItsParent) {
  const TempDir dir;
  std::mutex lock;
  std::unique_lock held(lock);
  int children = 0;
  const auto outcome = run(
      dir.write("a.obj", ""), {},
      [&](double) {
        if (++children == 2) held.unlock();
      },
      [&](Inside& inside) {
        inside.progress(0);
        lock.lock();
        inside.write("out", 3);
        inside.finish();
      });
  ASSERT_TRUE(outcome) << error_of(outcome);
  EXPECT_EQ(text_of(*outcome), "out");
  EXPECT_EQ(children, 3);
}

TEST(Sandbox, ReplacesAChildThatYieldsToAThreadOfItsParent) {
  const TempDir dir;
  std::atomic<bool> taken = true;
  int children = 0;
  const auto outcome = run(
      dir.write("a.obj", ""), {},
      [&](double) {
        if (++children == 2) taken = false;
      },
      [&](Inside& inside) {
        inside.progress(0);
        while (taken) std::this_thread::yield();
        inside.write("out", 3);
        inside.finish();
      });
  ASSERT_TRUE(outcome) << error_of(outcome);
  EXPECT_EQ(text_of(*outcome), "out");
  EXPECT_EQ(children, 3);
}

TEST(Sandbox, LimitsTimeOfAChildThatWaits) {
  const TempDir dir;
  const auto outcome = run_on(dir.write("a.obj", ""),
                              [](Inside&) { std::this_thread::sleep_for(std::chrono::hours(1)); },
                              {.time_us = {.fixed = 1, .per_byte = 1}});
  EXPECT_TRUE(holds(error_of(outcome), "takes more than the 1 s")) << error_of(outcome);
}

// A sanitizer reports the end of memory itself, which takes memory, or never ends.
#ifndef __SANITIZE_ADDRESS__
TEST(Sandbox, LimitsMemory) {
  const TempDir dir;
  const auto outcome = run_on(dir.write("a.obj", ""),
                              [](Inside& inside) {
                                std::vector<std::string> hoard;
                                for (int i = 0; i < 256; ++i)
                                  hoard.emplace_back(std::size_t{1} << 20, 'x');
                                inside.finish();
                              },
                              {.memory = {.fixed = std::uint64_t{64} << 20, .per_byte = 1}});
  ASSERT_FALSE(outcome);
  EXPECT_TRUE(holds(error_of(outcome), "takes more than the 64 MiB")) << error_of(outcome);
}
#endif

TEST(Sandbox, LimitsTheResult) {
  const TempDir dir;
  const auto outcome = run_on(dir.write("a.obj", ""),
                              [](Inside& inside) {
                                const std::string block(std::size_t{1} << 20, 'x');
                                for (int i = 0; i < 256; ++i)
                                  inside.write(block.data(), block.size());
                                inside.finish();
                              },
                              {.memory = {.fixed = std::uint64_t{64} << 20, .per_byte = 1}});
  EXPECT_FALSE(outcome);
}

// Else thousands of links to a large file would take page tables without a bound.
TEST(Sandbox, MapsAFileOnceUnderAllItsNames) {
  const TempDir dir;
  const std::string file = dir.write("a.obj", "first");
  std::filesystem::create_hard_link(file, dir.path("hard"));
  std::filesystem::create_symlink("a.obj", dir.path("soft"));
  const auto outcome = run_on(file, [](Inside& inside) {
    const auto first = inside.read("a.obj");
    bool same = first && *first == "first";
    for (const char* name : {"a.obj", "./a.obj", "hard", "soft"})
      same = same && inside.read(name)->data() == first->data();
    inside.write(same ? "same" : "else", 4);
    inside.finish();
  });
  ASSERT_TRUE(outcome) << error_of(outcome);
  EXPECT_EQ(text_of(*outcome), "same");
}

// Larger files may need more.
TEST(Sandbox, AllowsMoreForMoreBytes) {
  const Allowance allowance{.fixed = 10, .per_byte = 3};
  EXPECT_EQ(allowance.of(0), 10U);
  EXPECT_EQ(allowance.of(5), 25U);
  EXPECT_GE(allowance.of(~std::uint64_t{0}), std::uint64_t{1} << 61U);
}

}  // namespace
}  // namespace sightline::client::importer::sandbox
