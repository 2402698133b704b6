// Arrays in shared memory.
#include "client/shared_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "client/client.h"

namespace sightline::client {
namespace {

static_assert(!std::is_copy_constructible_v<SharedArray<double>>);
static_assert(std::is_convertible_v<SharedArray<double>, std::span<const double>>);

class SharedMemoryTest : public testing::Test {
 protected:
  // The memory of a client that uses no segments behaves alike.
  std::optional<Client> client_ = *Client::connect("unix:/nowhere", {.use_segments = false});
  std::optional<SharedMemory> memory_ = *client_->share_memory(4096);
};

TEST_F(SharedMemoryTest, ArraysLieInItBesideEachOther) {
  EXPECT_EQ(memory_->size(), 4096U);
  const auto one = memory_->array<double>(100);
  const auto other = memory_->array<std::uint8_t>(1);
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->size(), 100U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(one->data()) % alignof(double), 0U);
  EXPECT_GE(reinterpret_cast<const std::byte*>(other->data()),
            reinterpret_cast<const std::byte*>(one->end()));
  (*one)[99] = 5;
  const std::span<const double> view = *one;
  EXPECT_EQ(view[99], 5);
}

TEST_F(SharedMemoryTest, BytesAreFreeAgainWhenAnArrayGoes) {
  std::optional<SharedArray<float>> whole = *memory_->array<float>(1024);
  const auto more = memory_->array<float>(1);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, Code::kResourceExhausted);
  EXPECT_NE(more.error().message.find("4 bytes"), std::string::npos) << more.error().message;
  std::optional<SharedArray<float>> moved = *std::move(whole);
  whole.reset();
  EXPECT_FALSE(memory_->array<float>(1)) << "it was moved, and is still there";
  moved.reset();
  EXPECT_TRUE(memory_->array<float>(1024));
}

TEST_F(SharedMemoryTest, SizesThatNoMemoryHasAreRefused) {
  constexpr auto kMost = std::numeric_limits<std::size_t>::max();
  for (const std::size_t count :
       {kMost, kMost / sizeof(double), kMost / sizeof(double) + 1, std::size_t{513}})
    EXPECT_EQ(memory_->array<double>(count).error().code, Code::kResourceExhausted) << count;
  EXPECT_TRUE(memory_->array<double>(512));
  EXPECT_TRUE(memory_->array<double>(0));
  EXPECT_FALSE(client_->share_memory(kMost));
}

TEST_F(SharedMemoryTest, AnArrayOutlivesItsMemoryAndTheClient) {
  auto array = memory_->array<double>(10);
  ASSERT_TRUE(array);
  memory_.reset();
  client_.reset();
  (*array)[9] = 7;
  EXPECT_EQ((*array)[9], 7);
}

}  // namespace
}  // namespace sightline::client
