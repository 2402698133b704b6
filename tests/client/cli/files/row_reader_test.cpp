// Batches of rays that are there, and none that are waited for.
#include "client/cli/files/row_reader.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace sightline::client::cli::files {
namespace {

// Rays 0, 1, 2, ... in bursts; after each burst none is there until it is waited for.
class Bursts : public RowReader {
 public:
  explicit Bursts(std::vector<int> sizes) : sizes_(std::move(sizes)) {}

  Result<bool> next(RayRow& row) override {
    while (!sizes_.empty() && sizes_.front() == 0) sizes_.erase(sizes_.begin());
    if (sizes_.empty()) return false;
    --sizes_.front();
    row = {};
    row[0] = number_++;
    return true;
  }
  Result<bool> ready() override { return sizes_.empty() || sizes_.front() > 0; }
  Result<bool> wait(std::chrono::milliseconds) override { return !is_silent; }

  bool is_silent = false;

 private:
  std::vector<int> sizes_;
  double number_ = 0;
};

struct RowBuffer {
  std::vector<double> origins = std::vector<double>(12), directions = std::vector<double>(12);
  RayColumns<double> columns() { return {origins, directions}; }
};

TEST(RowReader, ABatchEndsWhereNoRayIsThere) {
  const auto reader = std::make_shared<Bursts>(std::vector<int>{2, 6});
  const LiveRays rays = live_rays(reader);
  RowBuffer buffer;
  EXPECT_TRUE(*rays.wait());
  EXPECT_EQ(*rays.source(buffer.columns()), 2U);
  EXPECT_EQ(buffer.origins[3], 1);
  EXPECT_EQ(*rays.source(buffer.columns()), 4U) << "no more than the buffer holds";
  EXPECT_EQ(buffer.origins[0], 2);
  EXPECT_EQ(*rays.source(buffer.columns()), 2U);
  EXPECT_EQ(*rays.source(buffer.columns()), 0U);
  EXPECT_FALSE(*rays.wait());
}

TEST(RowReader, ALongPauseEndsTheSourceAndWaitingGoesOn) {
  const auto reader = std::make_shared<Bursts>(std::vector<int>{1, 1});
  const LiveRays rays = live_rays(reader);
  RowBuffer buffer;
  EXPECT_EQ(*rays.source(buffer.columns()), 1U);
  reader->is_silent = true;
  EXPECT_EQ(*rays.source(buffer.columns()), 0U);
  EXPECT_TRUE(*rays.wait());
  EXPECT_EQ(*rays.source(buffer.columns()), 1U) << "the ray that was waited for";
  EXPECT_EQ(buffer.origins[0], 1);
}

}  // namespace
}  // namespace sightline::client::cli::files
