// Number formats, exit codes, and Ctrl-C in a running command.
#include <gtest/gtest.h>
#include <signal.h>

#include <condition_variable>
#include <limits>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "client/cli/terminal.h"
#include "client/scene_upload.h"
#include "tests/client/importer/gltf_file.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/silent_port.h"
#include "tests/client/support/temp_dir.h"
#include "tests/support/child_process.h"
#include "tests/support/rounds.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::client::cli {
namespace {

TEST(Amounts, DigitsAreGroupedInThrees) {
  EXPECT_EQ(format_count(0), "0");
  EXPECT_EQ(format_count(999), "999");
  EXPECT_EQ(format_count(1000), "1,000");
  EXPECT_EQ(format_count(1234567), "1,234,567");
  EXPECT_EQ(format_count(std::numeric_limits<std::uint64_t>::max()), "18,446,744,073,709,551,615");
}

TEST(Amounts, SharesAreZeroOrHundredPercentOnlyIfExact) {
  EXPECT_EQ(share(3, 4), 0.75);
  EXPECT_EQ(share(3, 0), 0);
  EXPECT_EQ(format_share(0, 0), "0 of 0");
  EXPECT_EQ(format_share(0, 5000), "0 of 5,000 (0 %)");
  EXPECT_EQ(format_share(1, 75730), "1 of 75,730 (below 0.1 %)");
  EXPECT_EQ(format_share(1211, 75730), "1,211 of 75,730 (1.6 %)");
  EXPECT_EQ(format_share(75729, 75730), "75,729 of 75,730 (99.9 %)");
  EXPECT_EQ(format_share(75730, 75730), "75,730 of 75,730 (100 %)");
}

TEST(Amounts, BytesUseDecimalUnits) {
  EXPECT_EQ(format_bytes(0), "0 B");
  EXPECT_EQ(format_bytes(999), "999 B");
  EXPECT_EQ(format_bytes(1000), "1.0 kB");
  EXPECT_EQ(format_bytes(999'949), "999.9 kB");
  EXPECT_EQ(format_bytes(999'950), "1.0 MB");
  EXPECT_EQ(format_bytes(81'036'012), "81.0 MB");
  EXPECT_EQ(format_bytes(12'000'000'000'000'000), "12000.0 TB");
}

TEST(ExitCode, IsTheDocumentedOne) {
  EXPECT_EQ(exit_code(Code::kNotFound), 3);
  EXPECT_EQ(exit_code(Code::kAlreadyExists), 4);
  EXPECT_EQ(exit_code(Code::kAborted), 4);
  EXPECT_EQ(exit_code(Code::kFailedPrecondition), 4);
  EXPECT_EQ(exit_code(Code::kUnavailable), 5);
  EXPECT_EQ(exit_code(Code::kDeadlineExceeded), 5);
  EXPECT_EQ(exit_code(Code::kUnauthenticated), 6);
  EXPECT_EQ(exit_code(Code::kPermissionDenied), 6);
  EXPECT_EQ(exit_code(Code::kResourceExhausted), 7);
  for (const Code code :
       {Code::kCancelled, Code::kUnknown, Code::kInvalidArgument, Code::kOutOfRange,
        Code::kUnimplemented, Code::kInternal, Code::kDataLoss}) {
    EXPECT_EQ(exit_code(code), 1);
  }
}

TEST(ExitCode, AnUnreadableLocalFileIsAFailure) {
  EXPECT_EQ(exit_code(local_error("no file").code), kFailed);
}

struct ChildProgram : tests::ChildProcess {
  explicit ChildProgram(const std::vector<std::string>& arguments)
      : ChildProcess(SIGHTLINE, arguments) {}
};

TEST(Terminal, ControlCharactersAreEscaped) {
  EXPECT_EQ(printable("a\x1b[2Jb\n\x7f"), "a\\x1b[2Jb\\x0a\\x7f");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\xc2\\x9b31m")
      << "CSI as one character";
  EXPECT_EQ(printable("a\x9b\xffz\xE2\x82"), "a\\x9b\\xffz\\xe2\\x82") << "no UTF-8";
  EXPECT_EQ(printable("K\xC3\xBC"
                      "che \xC2\xA7"),
            "K\xC3\xBC"
            "che \xC2\xA7");
}

TEST(Interrupt, RequestsOneStop) {
  for (int round = 0; round < 3; ++round) {
    const Interrupt interrupt;
    EXPECT_FALSE(interrupt.happened());
    std::mutex mutex;
    std::condition_variable changed;
    bool stopped = false;
    const std::stop_callback callback(interrupt.token(), [&] {
      const std::lock_guard lock(mutex);
      stopped = true;
      changed.notify_all();
    });
    raise(SIGINT);
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return stopped; });
    EXPECT_TRUE(interrupt.happened());
  }
}

TEST(Interrupt, ASecondInterruptEndsTheProcess) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const Interrupt interrupt;
        raise(SIGINT);
        raise(SIGINT);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(Interrupt, RestoresTheSignalHandlers) {
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction before {
    }, after{};
    sigaction(signal, nullptr, &before);
    { const Interrupt interrupt; }
    sigaction(signal, nullptr, &after);
    EXPECT_EQ(before.sa_handler, after.sa_handler);
  }
}

TEST(InterruptedProgram, EndsWithASilentServer) {
  const tests::SilentPort port;
  tests::TempDir dir;
  const std::string rays = dir.write("rays.csv", "0,0,1,0,0,-1\n");
  const std::string out = dir.path("hits.csv");
  const std::vector<std::vector<std::string>> verbs{
      {"prefetch", "s"},
      {"prefetch", "s", "--rays", rays},
      {"cast", "s", "--in", rays, "--out", out, "--build", "full"},
      {"cast", "s", "--in", rays, "--out", out, "--build", "lazy"},
      {"cast", "s", "--in", "-", "--out", out}};
  for (std::vector<std::string> arguments : verbs) {
    arguments.insert(arguments.end(), {"--endpoint", port.endpoint()});
    for (const auto& [signal, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
      ChildProgram program(arguments);
      ASSERT_TRUE(program.catches(signal)) << program.output();
      program.signal(signal);
      EXPECT_EQ(program.wait(), code) << arguments[0];
      EXPECT_EQ(program.output(), "sightline: interrupted\n");
    }
  }
  EXPECT_EQ(dir.names(), "rays.csv") << "no partial file is left";
}

// A wavy sheet of n x n squares, without equal rows.
importer::ImportedScene large_sheet(std::uint32_t n) {
  importer::ImportedScene scene;
  importer::ImportedMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const auto z = static_cast<float>((x * 7 + y * 13) % 11) * 0.01F;
      mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), z});
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t v = y * (n + 1) + x;
      mesh.faces.push_back({v, v + 1, v + n + 2});
      mesh.faces.push_back({v, v + n + 2, v + n + 1});
    }
  }
  mesh.triangles = mesh.faces.size();
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.push_back({.name = "sheet", .mesh = 0});
  return scene;
}

class InterruptedBuild : public tests::LiveClient {
 protected:
  // Building takes long after its first report.
  static constexpr std::uint32_t kTriangles = tests::kSanitized ? 500'000 : 2'000'000;

  InterruptedBuild() {
    const auto sheet = large_sheet(tests::kSanitized ? 500 : 1000);
    EXPECT_TRUE(upload_scene(client_, tests::kScene, sheet, {}));
  }

  void expect_right_hits() {
    const tests::DownwardRays rays(10, 10);
    std::vector<double> t(10);
    const auto cast = client_.cast_stream(tests::kScene, rays.columns(), {.t = t});
    ASSERT_TRUE(cast) << cast.error().message;
    EXPECT_EQ(cast->hits, 10U);
    for (const double each : t) EXPECT_NEAR(each, 5, 0.2);
  }

  tests::TempDir dir_;
};

TEST_F(InterruptedBuild, PrefetchReportsWhatIsBuiltAndTheSceneIsUsable) {
  ChildProgram program({"prefetch", "test", "--endpoint", endpoint()});
  ASSERT_TRUE(program.writes("building: ")) << program.output();
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 130) << program.output();
  EXPECT_NE(program.output().find("interrupted, and what is built stays"), std::string::npos);
  const std::string_view all = tests::kSanitized ? "of 500,000" : "of 2,000,000";
  EXPECT_NE(program.output().find(all), std::string::npos) << program.output();
  expect_right_hits();
  ChildProgram again({"prefetch", "test", "--endpoint", endpoint()});
  EXPECT_EQ(again.wait(), 0) << again.output();
  EXPECT_EQ(client_.scene_stats(tests::kScene)->triangles_built, kTriangles);
  expect_right_hits();
}

using InterruptedStream = tests::LiveClient;

TEST_F(InterruptedStream, EndsAfterAllAnswers) {
  tests::TempDir dir;
  const std::string file = dir.write("strip.gltf", tests::bending_strip().text());
  ChildProgram program({"stream", "test", "--animate", file, "--loops", "0", "--fps", "200",
                        "--json", "--endpoint", endpoint()});
  const auto at_work = [&] {
    const auto scene = client_.get_scene(tests::kScene);
    return scene && scene->revision > 10;
  };
  while (!at_work()) tests::sleep_shortly();
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 130) << program.output();
  EXPECT_NE(program.output().find("\"complete\": false"), std::string::npos);
  const std::uint64_t revision = client_.get_scene(tests::kScene)->revision;
  EXPECT_NE(program.output().find("at revision " + std::to_string(revision)), std::string::npos)
      << program.output();
}

TEST_F(InterruptedBuild, CastInFullLeavesNoFile) {
  const std::string rays = dir_.write("rays.csv", "0.5,0.25,5,0,0,-1\n");
  const std::string out = dir_.path("hits.csv");
  const std::vector<std::string> cast{"cast", "test",    "--in", rays,         "--out",
                                      out,    "--build", "full", "--endpoint", endpoint()};
  ChildProgram program(cast);
  ASSERT_TRUE(program.writes("building: ")) << program.output();
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 130) << program.output();
  EXPECT_EQ(dir_.names(), "rays.csv");
  ChildProgram again(cast);
  EXPECT_EQ(again.wait(), 0) << again.output();
  EXPECT_EQ(dir_.names(), "hits.csv rays.csv");
  expect_right_hits();
}

}  // namespace

}  // namespace sightline::client::cli
