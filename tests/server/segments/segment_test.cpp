// A segment: its seals, its bytes, and what stays of it.
#include "server/segments/segment.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "tests/server/support/shared_segment.h"

namespace sightline::server::segments {
namespace {

using tests::pages_of;

class SegmentTest : public testing::Test {
 protected:
  std::shared_ptr<const Segment> make(std::uint64_t bytes) {
    auto held = account_.hold({"a", "a:1"}, bytes);
    EXPECT_TRUE(held);
    auto made = Segment::make(bytes, "a", std::move(*held));
    EXPECT_TRUE(made) << (made ? "" : made.error().message);
    return made ? *made : nullptr;
  }

  exec::MemoryAccount memory_{std::uint64_t{64} << 20};
  SegmentAccount account_{memory_};
};

TEST_F(SegmentTest, HasItsPagesFromTheBeginning) {
  const auto segment = make(16 * page_size());
  EXPECT_EQ(segment->size(), 16 * page_size());
  EXPECT_EQ(pages_of(segment->descriptor()), 16u);
  EXPECT_EQ(memory_.used(exec::Held::kSegments), 16 * page_size());
  std::string read(segment->size(), 'x');
  segment->read(0, read.data(), read.size());
  EXPECT_EQ(read, std::string(read.size(), '\0'));
}

TEST_F(SegmentTest, CannotBeShrunkGrownOrSealed) {
  const auto segment = make(4 * page_size());
  EXPECT_EQ(ftruncate(segment->descriptor(), 0), -1);
  EXPECT_EQ(errno, EPERM);
  EXPECT_EQ(ftruncate(segment->descriptor(), static_cast<off_t>(8 * page_size())), -1);
  EXPECT_EQ(errno, EPERM);
  EXPECT_EQ(fcntl(segment->descriptor(), F_ADD_SEALS, F_SEAL_WRITE), -1);
  EXPECT_EQ(errno, EPERM);
}

TEST_F(SegmentTest, IsSharedWithWhoeverMapsIt) {
  const auto segment = make(2 * page_size());
  void* const other =
      mmap(nullptr, segment->size(), PROT_READ | PROT_WRITE, MAP_SHARED, segment->descriptor(), 0);
  ASSERT_NE(other, MAP_FAILED);
  segment->write(page_size() - 2, "four", 4);
  char* const bytes = static_cast<char*>(other) + page_size();
  EXPECT_EQ(std::string(bytes - 2, 4), "four");
  bytes[0] = 'X';
  std::string read(4, ' ');
  segment->read(page_size() - 2, read.data(), read.size());
  EXPECT_EQ(read, "foXr");
  munmap(other, segment->size());
}

/// A page that a client gives back is zero again, and no signal comes.
TEST_F(SegmentTest, StandsItsPagesBeingGivenBack) {
  if (!Segment::is_safe()) GTEST_SKIP() << "vm.overcommit_memory is 2";
  const auto segment = make(2 * page_size());
  segment->write(0, "four", 4);
  ASSERT_EQ(fallocate(segment->descriptor(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
                      static_cast<off_t>(segment->size())),
            0);
  std::string read(4, ' ');
  segment->read(0, read.data(), read.size());
  EXPECT_EQ(read, std::string(4, '\0'));
  segment->write(0, "more", 4);
}

TEST_F(SegmentTest, LeavesToAClientWhatItHasMapped) {
  auto segment = make(16 * page_size());
  segment->write(0, "four", 4);
  const net::Descriptor kept(dup(segment->descriptor()));
  void* const mapped =
      mmap(nullptr, segment->size(), PROT_READ | PROT_WRITE, MAP_SHARED, kept.number(), 0);
  ASSERT_NE(mapped, MAP_FAILED);
  EXPECT_EQ(static_cast<const char*>(mapped)[0], 'f');
  segment.reset();
  EXPECT_EQ(memory_.used(), 0u);
  EXPECT_EQ(static_cast<const char*>(mapped)[0], 'f');
  munmap(mapped, 16 * page_size());
}

TEST_F(SegmentTest, TakesItsPagesFromAClientThatIsGone) {
  auto segment = make(16 * page_size());
  segment->write(0, "four", 4);
  const net::Descriptor kept(dup(segment->descriptor()));
  char* const mapped = static_cast<char*>(
      mmap(nullptr, segment->size(), PROT_READ | PROT_WRITE, MAP_SHARED, kept.number(), 0));
  ASSERT_NE(mapped, MAP_FAILED);
  segment->note_client_gone();
  EXPECT_EQ(mapped[0], 'f') << "a cast may be at it";
  EXPECT_EQ(pages_of(kept.number()), 16u);
  segment.reset();
  EXPECT_EQ(memory_.used(), 0u);
  EXPECT_EQ(pages_of(kept.number()), 0u);
  EXPECT_EQ(mapped[0], '\0');
  mapped[0] = 'x';  // a page of its own
  EXPECT_EQ(pages_of(kept.number()), 1u);
  munmap(mapped, 16 * page_size());
}

}  // namespace
}  // namespace sightline::server::segments
