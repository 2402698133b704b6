// The verb doctor: what it prints, and its exit codes.
#include "server/doctor_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "server/config.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server {
namespace {

using testing::HasSubstr;

/// The exit code; `out` gets what was printed.
int run(std::vector<const char*> arguments, std::string& out) {
  arguments.insert(arguments.begin(), "doctor");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = run_doctor(static_cast<int>(arguments.size()), arguments.data());
  out = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
  return code;
}

TEST(DoctorCommand, SaysThatADirectoryIsSound) {
  const tests::Directory directory;
  tests::open_store(directory.path()).reset();
  std::string out;
  EXPECT_EQ(run({directory.path().c_str()}, out), 0);
  EXPECT_THAT(out, HasSubstr("is sound"));
}

TEST(DoctorCommand, PrintsALineForEachFindingAndRepair) {
  const tests::Directory directory;
  tests::open_store(directory.path()).reset();
  const auto orphan = directory.path() / "blobs" / "00" / std::string(64, '0');
  std::ofstream(orphan) << "x";
  std::string out;
  EXPECT_EQ(run({directory.path().c_str()}, out), 1);
  EXPECT_THAT(out, HasSubstr("found: " + orphan.string()));
  EXPECT_EQ(run({directory.path().c_str(), "--repair"}, out), 1);
  EXPECT_THAT(out, HasSubstr("repaired: removed " + orphan.string()));
  EXPECT_EQ(run({directory.path().c_str()}, out), 0);
}

TEST(DoctorCommand, FailsWithoutADirectory) {
  std::string out;
  EXPECT_EQ(run({}, out), kUsageExit);
  EXPECT_EQ(run({"/nonexistent"}, out), 1);
  EXPECT_THAT(out, HasSubstr("--data-dir"));
}

}  // namespace
}  // namespace sightline::server
