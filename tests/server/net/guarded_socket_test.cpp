#include "server/net/guarded_socket.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "tests/server/support/frames.h"

namespace sightline::tests {
namespace {

using server::net::Abuse;
using server::net::FrameHead;
using server::net::GuardedSocket;

/// Buffers of the given sizes, one after another.
class Buffers {
 public:
  explicit Buffers(std::vector<std::size_t> sizes) {
    std::size_t all = 0;
    for (const std::size_t size : sizes) all += size;
    text_.resize(all);
    std::size_t begin = 0;
    for (const std::size_t size : sizes) {
      list_.push_back({text_.data() + begin, size});
      begin += size;
    }
  }
  std::span<const iovec> put(std::string_view text) {
    text.copy(text_.data(), text.size());
    return list_;
  }
  std::string first(std::size_t size) const { return text_.substr(0, size); }

 private:
  std::string text_;
  std::vector<iovec> list_;
};

class GuardedSocketTest : public testing::Test {
 protected:
  static std::string pings(std::size_t size) {
    std::string all;
    while (all.size() < size) all += frame(FrameHead::kPing, 0, 0, std::string(8, '\0'));
    return all.substr(0, size);
  }
  /// All pings that are put in place of a client's bytes.
  static constexpr std::size_t kAll = 8 * 17;

  const std::string greeting_ = std::string(kPreface) + frame(FrameHead::kSettings, 0, 0);
  const std::string bad_ = frame(FrameHead::kContinuation, 0, 1);
  const std::shared_ptr<server::net::EndedConnections> ended_ =
      std::make_shared<server::net::EndedConnections>();
  GuardedSocket socket_{-1, 64, ended_};
};

TEST_F(GuardedSocketTest, LeavesGoodBytesAlone) {
  Buffers buffers({100});
  EXPECT_EQ(socket_.received(buffers.put(greeting_), greeting_.size()), greeting_.size());
  EXPECT_EQ(buffers.first(greeting_.size()), greeting_);
  EXPECT_EQ(socket_.instead(buffers.put("")), std::nullopt);
  EXPECT_FALSE(socket_.is_over());
}

TEST_F(GuardedSocketTest, ReplacesBadBytesWithPings) {
  // Whatever the sizes of the buffers are, the bytes are the same.
  for (std::size_t cut = 1; cut < greeting_.size(); ++cut) {
    GuardedSocket socket(-1, 64, ended_);
    Buffers buffers({cut, 300 - cut});
    const std::string all = greeting_ + bad_ + "more";
    const std::size_t size = socket.received(buffers.put(all), all.size());
    ASSERT_EQ(size, greeting_.size() + kAll);
    EXPECT_EQ(buffers.first(size), greeting_ + pings(kAll));
    EXPECT_TRUE(socket.is_over());
    EXPECT_EQ(socket.instead(buffers.put("")), 0u);
  }
  EXPECT_EQ(ended_->count(Abuse::kHeaders), greeting_.size() - 1);
}

TEST_F(GuardedSocketTest, PutsThemOneByOneIntoSmallBuffers) {
  Buffers first({greeting_.size() + bad_.size()});
  const std::string all = greeting_ + bad_;
  std::string taken = first.first(0);
  ASSERT_EQ(socket_.received(first.put(all), all.size()), all.size());
  taken = first.first(all.size()).substr(greeting_.size());
  for (std::optional<std::size_t> size = 1; size != 0u;) {
    EXPECT_EQ(socket_.is_over(), taken.size() == kAll);
    Buffers next({3, 4});
    size = socket_.instead(next.put(""));
    ASSERT_TRUE(size);
    taken += next.first(*size);
  }
  EXPECT_EQ(taken, pings(kAll));
  EXPECT_TRUE(socket_.is_over());
}

TEST_F(GuardedSocketTest, BytesThatAreWrittenInPiecesCountOnce) {
  Buffers in({20'000});
  socket_.received(in.put(greeting_), greeting_.size());
  // Each call has an answer, which the system takes byte by byte: a place for the next call.
  for (std::uint32_t stream = 1; stream < 1'000; stream += 2) {
    const std::string call = headers(stream);
    ASSERT_EQ(socket_.received(in.put(call), call.size()), call.size()) << stream;
    const std::string answer =
        frame(FrameHead::kHeaders, FrameHead::kEndHeaders | FrameHead::kEndStream, stream, "ok");
    for (std::size_t at = 0; at < answer.size(); ++at) {
      Buffers out({answer.size() - at});
      socket_.sending(out.put(answer.substr(at)));
      socket_.sent(-1);
      socket_.sending(out.put(answer.substr(at)));
      socket_.sent(1);
    }
  }
}

}  // namespace
}  // namespace sightline::tests
