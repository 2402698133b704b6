// The count of open calls: what it waits for, and what it does not.
#include "server/exec/open_rpcs.h"

#include <gtest/gtest.h>

#include <thread>

namespace sightline::server::exec {
namespace {

TEST(OpenRpcs, WaitsUntilTheLastCallHasEnded) {
  OpenRpcs calls;
  calls.wait_for_none(std::chrono::hours(1));
  calls.begin();
  calls.begin();
  std::thread ends([&] {
    calls.end();
    calls.end();
  });
  calls.wait_for_none(std::chrono::hours(1));
  ends.join();
}

TEST(OpenRpcs, WaitsNoLongerThanItsLimit) {
  OpenRpcs calls;
  calls.begin();
  calls.wait_for_none(std::chrono::milliseconds(1));
}

}  // namespace
}  // namespace sightline::server::exec
