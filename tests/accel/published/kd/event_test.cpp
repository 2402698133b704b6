// The order of events.
#include "accel/published/kd/event.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "accel/published/kd/radix_sort.h"
#include "tests/support/random.h"

namespace sightline::accel::published::kd {
namespace {

TEST(Event, KeepsItsParts) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  for (const float x : {-kLargest, -1.5f, -1e-38f, 0.0f, 1e-38f, 2.0f, kLargest}) {
    for (const EventType type : {EventType::kEnd, EventType::kPlanar, EventType::kStart}) {
      for (const std::uint32_t reference :
           {0u, 7u, static_cast<std::uint32_t>(Event::kMaxReferences - 1)}) {
        const Event event(x, type, reference);
        EXPECT_EQ(event.position(), x);
        EXPECT_EQ(event.type(), type);
        EXPECT_EQ(event.reference(), reference);
      }
    }
  }
  EXPECT_EQ(Event(-0.0f, EventType::kEnd, 1), Event(0.0f, EventType::kEnd, 1));
}

TEST(Event, OrdersByPositionThenTypeThenReference) {
  const std::vector<Event> ordered = {
      Event(-2, EventType::kStart, 9),  Event(-1, EventType::kEnd, 0),
      Event(0, EventType::kEnd, 5),     Event(0, EventType::kPlanar, 2),
      Event(0, EventType::kPlanar, 3),  Event(0, EventType::kStart, 1),
      Event(1e-3f, EventType::kEnd, 0), Event(4, EventType::kEnd, 0),
  };
  for (std::size_t i = 0; i + 1 < ordered.size(); ++i) EXPECT_LT(ordered[i], ordered[i + 1]);
}

TEST(Event, OfAFlatBoxIsOne) {
  Event events[2];
  EXPECT_EQ(put_events(1, geometry::least_above(1), 4, events) - events, 1);
  EXPECT_EQ(events[0], Event(1, EventType::kPlanar, 4));
  EXPECT_EQ(put_events(1, 2, 4, events) - events, 2);
  EXPECT_EQ(events[0], Event(1, EventType::kStart, 4));
  EXPECT_EQ(events[1], Event(2, EventType::kEnd, 4));
}

TEST(SortEvents, SortsLongAndShortListsTheSameWay) {
  tests::Random random(3);
  for (const std::uint32_t boxes : {0u, 1u, 100u, 30000u}) {
    std::vector<Event> events(2 * boxes);
    Event* end = events.data();
    for (std::uint32_t i = 0; i < boxes; ++i) {
      // Half of them on a lattice, so that many are equal.
      const double x =
          i % 2 == 0 ? static_cast<double>(random.below(5)) - 2 : random.uniform(-1e3, 1e3);
      const auto lo = static_cast<float>(x);
      end = put_events(lo, i % 3 == 0 ? geometry::least_above(lo) : lo + 1, i, end);
    }
    events.resize(static_cast<std::size_t>(end - events.data()));
    std::vector<Event> expected = events;
    std::sort(expected.begin(), expected.end());
    sort_events(events);
    EXPECT_EQ(events, expected);
  }
}

TEST(SortTouches, CountsKLogK) {
  EXPECT_EQ(sort_touches(0), 0u);
  EXPECT_EQ(sort_touches(1), 0u);
  EXPECT_EQ(sort_touches(2), 2u);
  EXPECT_EQ(sort_touches(5), 15u);
  EXPECT_EQ(sort_touches(1024), 10240u);
}

}  // namespace
}  // namespace sightline::accel::published::kd
