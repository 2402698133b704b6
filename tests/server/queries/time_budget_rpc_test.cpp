// Time budgets of queries through a real server: marks of rays without an answer, and asking again.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "scenegraph/trace_options.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

constexpr std::uint8_t kNoTime = 4;
constexpr std::uint32_t kLongBudget = 3'600'000;
constexpr std::size_t kBudgetRays = 4000;

bool lacks_answer(const v1::CastRaysResponse& reply, std::size_t ray) {
  const std::string& bits = reply.unanswered();
  return !bits.empty() && (static_cast<unsigned char>(bits[ray / 8]) >> ray % 8 & 1) != 0;
}

class TimeBudgetRpc : public LiveServer {
 protected:
  v1::CastRaysRequest request(v1::QueryKind kind, std::uint32_t budget_ms) {
    v1::CastRaysRequest request = cast_request(kScene, rays_downward(kBudgetRays));
    request.set_kind(kind);
    request.clear_fields();
    request.set_time_budget_ms(budget_ms);
    return request;
  }

  /// The marks of a reply agree with each other.
  static void check_marks(const v1::CastRaysResponse& reply, v1::QueryKind kind) {
    std::uint64_t marked = 0;
    const auto t = column_values<double>(reply, v1::HIT_FIELD_T);
    const auto hit = column_values<std::uint8_t>(reply, v1::HIT_FIELD_HIT);
    const auto count = column_values<std::uint32_t>(reply, v1::HIT_FIELD_COUNT);
    for (std::size_t i = 0; i < kBudgetRays; ++i) {
      const bool unanswered = lacks_answer(reply, i);
      marked += unanswered ? 1 : 0;
      if (kind == v1::QUERY_KIND_CLOSEST) {
        ASSERT_EQ(t[i] == -std::numeric_limits<double>::infinity(), unanswered);
      }
      if (!hit.empty()) {
        ASSERT_EQ(hit[i] == kNoTime, unanswered);
      }
      if (!count.empty()) {
        ASSERT_EQ(count[i] == scenegraph::kUnansweredCount, unanswered);
      }
    }
    EXPECT_EQ(reply.stats().rays(), kBudgetRays);
    EXPECT_EQ(reply.stats().unanswered(), marked);
    EXPECT_EQ(reply.unanswered().empty(), marked == 0);
  }

  const std::string kScene = "projects/default/scenes/budget";
};

TEST_F(TimeBudgetRpc, MarksAgreeForEveryKindAndAskingAgainEnds) {
  api_.make_scene(kScene, icosphere(7));
  for (const v1::QueryKind kind :
       {v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_ANY, v1::QUERY_KIND_COUNT}) {
    v1::CastRaysResponse reply;
    // The budget grows, so that this ends on any machine.
    for (std::uint32_t budget = 1; budget < kLongBudget; budget *= 2) {
      reply = api_.cast(request(kind, budget));
      check_marks(reply, kind);
      if (reply.stats().unanswered() == 0) break;
    }
    EXPECT_EQ(reply.stats().unanswered(), 0u);
    const v1::CastRaysResponse unbounded = api_.cast(request(kind, 0));
    ASSERT_EQ(unbounded.columns_size(), reply.columns_size());
    for (int i = 0; i < reply.columns_size(); ++i)
      EXPECT_EQ(unbounded.columns(i).data(), reply.columns(i).data());
  }
}

TEST_F(TimeBudgetRpc, ListsHaveMarks) {
  api_.make_scene(kScene, icosphere(7));
  v1::CastRaysRequest all = request(v1::QUERY_KIND_ALL, 1);
  all.set_max_hits(4);
  for (std::uint32_t budget = 1; budget < kLongBudget; budget *= 2) {
    all.set_time_budget_ms(budget);
    const v1::CastRaysResponse reply = api_.cast(all);
    const auto hit = column_values<std::uint8_t>(reply, v1::HIT_FIELD_HIT);
    const auto offset = column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET);
    ASSERT_EQ(hit.size(), kBudgetRays);
    for (std::size_t i = 0; i < kBudgetRays; ++i) {
      ASSERT_EQ(hit[i] == kNoTime, lacks_answer(reply, i));
      if (hit[i] == kNoTime) {
        ASSERT_EQ(offset[i], offset[i + 1]);
      }
    }
    EXPECT_EQ(reply.stats().rays(), kBudgetRays);
    if (reply.stats().unanswered() == 0) return;
  }
  FAIL() << "there are always rays without an answer";
}

TEST_F(TimeBudgetRpc, BitsOfUnansweredRaysAreClear) {
  api_.make_scene(kScene, icosphere(7));
  v1::CastRaysRequest any = request(v1::QUERY_KIND_ANY, 1);
  any.add_fields(v1::HIT_FIELD_HIT_BITS);
  const v1::CastRaysResponse reply = api_.cast(any);
  const auto bits = column_values<std::uint8_t>(reply, v1::HIT_FIELD_HIT_BITS);
  for (std::size_t i = 0; i < kBudgetRays; ++i) {
    if (lacks_answer(reply, i)) {
      ASSERT_EQ(bits[i / 8] >> i % 8 & 1, 0);
    }
  }
}

TEST_F(TimeBudgetRpc, AFullBuildEndsWithTheBudget) {
  api_.make_scene(kScene, icosphere(7));
  v1::CastRaysRequest full = request(v1::QUERY_KIND_CLOSEST, 1);
  full.set_build(v1::BUILD_MODE_FULL);
  check_marks(api_.cast(full), v1::QUERY_KIND_CLOSEST);
}

}  // namespace
}  // namespace sightline::tests
