// The contract with scripts.
#include "client/cli/exit_code.h"

#include <gtest/gtest.h>

namespace sightline::client::cli {
namespace {

TEST(ExitCode, IsTheContract) {
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

}  // namespace
}  // namespace sightline::client::cli
