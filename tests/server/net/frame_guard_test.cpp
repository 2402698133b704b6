#include "server/net/frame_guard.h"

#include <gtest/gtest.h>

#include "tests/server/support/frames.h"

namespace sightline::tests {
namespace {

using namespace std::chrono_literals;
using server::net::Abuse;
using server::net::FrameGuard;
using server::net::FrameHead;

constexpr std::size_t kMaxStreams = 64;
constexpr std::uint8_t kEndOfCall = FrameHead::kEndHeaders | FrameHead::kEndStream;

/// A connection whose client has sent its preface.
class Connection {
 public:
  Connection() { EXPECT_FALSE(receive(std::string(kPreface) + frame(FrameHead::kSettings, 0, 0))); }

  std::optional<FrameGuard::Verdict> receive(std::string_view text) {
    return guard_.receive(bytes_of(text), now);
  }
  void send(std::string_view text) { guard_.send(bytes_of(text), now); }
  /// The server has sent its settings and knows that the client has them.
  void acknowledge() {
    send(frame(FrameHead::kSettings, 0, 0));
    EXPECT_FALSE(receive(frame(FrameHead::kSettings, FrameHead::kAck, 0)));
  }
  /// How many of these pieces are taken, up to `most`.
  template <class Make>
  int taken(Make make, int most) {
    for (int i = 0; i < most; ++i) {
      const auto verdict = receive(make(static_cast<std::uint32_t>(2 * i + 1)));
      if (!verdict) continue;
      abuse = verdict->abuse;
      return i;
    }
    return most;
  }

  FrameGuard::Clock::time_point now{};
  std::optional<Abuse> abuse;

 private:
  static std::span<const std::uint8_t> bytes_of(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  }

  FrameGuard guard_{kMaxStreams, now};
};

TEST(FrameGuard, TakesAsManyStreamsAsTheSettingsSay) {
  Connection connection;
  connection.acknowledge();
  EXPECT_EQ(connection.taken([](auto stream) { return headers(stream); }, 1000), 64);
  EXPECT_EQ(connection.abuse, Abuse::kStreams);
}

TEST(FrameGuard, TakesSomeMoreFromAClientThatMayNotKnowThem) {
  Connection connection;
  // It cannot acknowledge what was not sent.
  EXPECT_FALSE(connection.receive(frame(FrameHead::kSettings, FrameHead::kAck, 0)));
  EXPECT_EQ(connection.taken([](auto stream) { return headers(stream); }, 1000), 100);
  EXPECT_EQ(connection.abuse, Abuse::kStreams);
}

TEST(FrameGuard, AnAnsweredStreamIsClosed) {
  Connection connection;
  connection.acknowledge();
  const auto call = [&](std::uint32_t stream) {
    if (stream > 100) connection.send(frame(FrameHead::kHeaders, kEndOfCall, stream - 100));
    return headers(stream);
  };
  EXPECT_EQ(connection.taken(call, 10'000), 10'000);
}

TEST(FrameGuard, BoundsCancelledCalls) {
  const auto cancelled = [](auto stream) { return headers(stream) + reset(stream, 8); };
  Connection connection;
  EXPECT_EQ(connection.taken(cancelled, 10'000), 200);
  EXPECT_EQ(connection.abuse, Abuse::kResets);
}

TEST(FrameGuard, TimeAllowsForMoreCancelledCalls) {
  Connection connection;
  const auto cancelled = [&](auto stream) {
    connection.now += 500us;
    return headers(stream) + reset(stream, 8);
  };
  connection.acknowledge();
  EXPECT_EQ(connection.taken(cancelled, 10'000), 10'000);
}

TEST(FrameGuard, AnAnswerAllowsForACancelledCall) {
  Connection connection;
  connection.acknowledge();
  const auto hedged = [&](std::uint32_t stream) {
    if (stream % 4 == 1) return headers(stream);
    connection.send(frame(FrameHead::kHeaders, kEndOfCall, stream - 2));
    return headers(stream) + reset(stream, 8);
  };
  EXPECT_EQ(connection.taken(hedged, 10'000), 10'000);
}

TEST(FrameGuard, ClientsCannotMakeTheServerGiveUp) {
  Connection connection;
  connection.acknowledge();
  const auto bad = [&](std::uint32_t stream) {
    if (stream > 1) connection.send(reset(stream - 2, 1));
    return headers(stream);
  };
  EXPECT_EQ(connection.taken(bad, 10'000), 201);
  EXPECT_EQ(connection.abuse, Abuse::kResets);
}

TEST(FrameGuard, TheEndOfAnAnsweredCallIsNoReset) {
  Connection connection;
  connection.acknowledge();
  const auto answered = [&](std::uint32_t stream) {
    if (stream > 1)
      connection.send(frame(FrameHead::kHeaders, kEndOfCall, stream - 2) + reset(stream - 2, 0));
    return headers(stream) + (stream > 1 ? reset(stream - 2, 8) : "");
  };
  EXPECT_EQ(connection.taken(answered, 10'000), 10'000);
}

TEST(FrameGuard, FieldsAreInOneFrame) {
  for (const std::string& bad :
       {frame(FrameHead::kHeaders, 0, 1, "f"),
        frame(FrameHead::kContinuation, FrameHead::kEndHeaders, 1),
        frame(FrameHead::kContinuation, 0, 1), headers(1, FrameGuard::kMaxFields + 1)}) {
    Connection connection;
    const auto verdict = connection.receive(bad);
    ASSERT_TRUE(verdict);
    EXPECT_EQ(verdict->abuse, Abuse::kHeaders);
    EXPECT_EQ(verdict->at, 0U);
  }
  EXPECT_FALSE(Connection().receive(headers(1, FrameGuard::kMaxFields)));
}

TEST(FrameGuard, FieldsAreFewUntilTheSettingsAreAcknowledged) {
  const auto large = [](auto stream) { return headers(stream, 10'000); };
  Connection connection;
  EXPECT_EQ(connection.taken(large, 60), 6);
  EXPECT_EQ(connection.abuse, Abuse::kHeaders);
  Connection good;
  good.acknowledge();
  EXPECT_EQ(good.taken(large, 60), 60);
}

TEST(FrameGuard, BoundsEmptyFrames) {
  const struct {
    std::string frame;
    int taken;
  } cases[] = {
      {frame(FrameHead::kData, 0, 1), 20'000},
      {frame(FrameHead::kData, 0, 1, "x"), 20'000},
      {frame(kPriority, 0, 1, "12345"), 20'000},
      {frame(FrameHead::kResetStream, 0, 1, "1234"), 20'000},
      {frame(FrameHead::kSettings, FrameHead::kAck, 0), 20'000},
      {frame(FrameHead::kPing, FrameHead::kAck, 0, "12345678"), 20'000},
      {frame(kServerPush, 0, 1), 20'000},
      {frame(FrameHead::kWindowUpdate, 0, 0, "1234"), 20'000},
      {frame(0x77, 0, 0), 20'000},
      {frame(FrameHead::kSettings, 0, 0), 1'999},  // one was in the greeting
      {frame(FrameHead::kPing, 0, 0, "12345678"), 16},
      {frame(FrameHead::kGoAway, 0, 0, "12345678"), 1'999},
      {headers(2), 1'999},
      {frame(FrameHead::kSettings, 0, 0, std::string(16'200, 's')), 75},
  };
  for (const auto& [bad, taken] : cases) {
    Connection connection;
    EXPECT_NEAR(connection.taken([&](auto) { return bad; }, 100'000), taken, 10) << int{bad[3]};
    EXPECT_EQ(connection.abuse, Abuse::kFrames);
  }
}

TEST(FrameGuard, DataAllowsForAnyNumberOfFrames) {
  Connection connection;
  const std::string data = frame(FrameHead::kData, 0, 1, std::string(FrameGuard::kSmallData, 'd'));
  EXPECT_EQ(connection.taken([&](auto) { return data; }, 100'000), 100'000);
  const std::string end = frame(FrameHead::kData, FrameHead::kEndStream, 1);
  EXPECT_EQ(connection.taken([&](auto) { return end; }, 100'000), 100'000);
}

TEST(FrameGuard, AnswersAllowForFrames) {
  Connection connection;
  const auto read = [&](auto) {
    connection.send(frame(FrameHead::kData, 0, 1, "answer"));
    return frame(FrameHead::kWindowUpdate, 0, 0, "1234") +
           frame(FrameHead::kWindowUpdate, 0, 1, "1234") +
           frame(FrameHead::kPing, 0, 0, "12345678");
  };
  EXPECT_EQ(connection.taken(read, 100'000), 100'000);
}

TEST(FrameGuard, AVerdictIsBeforeAWholeFrame) {
  const std::string good = frame(FrameHead::kData, 0, 1, std::string(100, 'd'));
  const std::string bad = frame(FrameHead::kHeaders, 0, 1, "fields");
  const std::string all = good + bad + good;
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    Connection connection;
    const auto first = connection.receive(std::string_view(all).substr(0, cut));
    const auto second = first ? first : connection.receive(std::string_view(all).substr(cut));
    ASSERT_TRUE(second) << cut;
    const std::size_t at = second->at + (first ? 0 : cut);
    // A frame whose head was cut goes its way.
    const bool in_head = cut > good.size() && cut < good.size() + 9;
    EXPECT_EQ(at, in_head ? good.size() + bad.size() : good.size()) << cut;
  }
}

}  // namespace
}  // namespace sightline::tests
