// Errors of the system name the file and what to do.
#include "server/store/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

namespace sightline::server::store {
namespace {

using testing::HasSubstr;

TEST(StoreErrors, TellAFullDiskFromABrokenOne) {
  const Error full = file_error("write", "/data/x", ENOSPC);
  EXPECT_EQ(full.code, Code::kResourceExhausted);
  EXPECT_EQ(full.reason, "DISK_FULL");
  EXPECT_THAT(full.message, HasSubstr("/data/x"));
  EXPECT_THAT(full.message, HasSubstr("free space"));
  const Error read_only = file_error("write", "/data/x", EROFS);
  EXPECT_EQ(read_only.code, Code::kFailedPrecondition);
  EXPECT_EQ(read_only.reason, "STORE_READ_ONLY");
  const Error broken = file_error("write", "/data/x", EIO);
  EXPECT_EQ(broken.code, Code::kUnavailable);
  EXPECT_EQ(broken.reason, "STORE_IO");
  EXPECT_THAT(broken.message, HasSubstr("cannot write /data/x: Input/output error"));
}

TEST(StoreErrors, NameALimitAndItsUse) {
  EXPECT_EQ(over_limit("log_bytes", 21, 20, "LOG_FULL").message,
            "log_bytes would be 21, the limit is 20");
}

}  // namespace
}  // namespace sightline::server::store
