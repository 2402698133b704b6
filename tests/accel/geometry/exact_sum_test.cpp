// Exact arithmetic against 128-bit integers.
#include "accel/geometry/exact_sum.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

__extension__ using Int128 = __int128;

int sign_of(Int128 x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

TEST(ExactSum, KeepsBitsThatADoubleLoses) {
  ExactSum e(1e100);
  e.add(1);
  e.add(-1e100);
  EXPECT_EQ(e.estimate(), 1);
  e.add(-1);
  EXPECT_EQ(e.sign(), 0);
}

TEST(ExactSum, DifferenceIsExact) {
  const ExactSum e = ExactSum::difference(1e20, 1e-20);
  ExactSum check = e;
  check.add(-1e20);
  EXPECT_EQ(check.estimate(), -1e-20);
}

TEST(ExactSum, SignsOfSumsOfProductsAreThoseOfIntegers) {
  tests::Random random(3);
  for (int round = 0; round < 20000; ++round) {
    Int128 exact = 0;
    ExactSum e;
    std::int64_t last_a = 0, last_b = 0;
    for (int term = 0; term < 6; ++term) {
      std::int64_t a = static_cast<std::int64_t>(random.next() >> 12) - (std::int64_t{1} << 51);
      std::int64_t b = static_cast<std::int64_t>(random.next() >> 12) - (std::int64_t{1} << 51);
      if (term % 2 == 1) {  // Nearly cancels the term before
        a = -last_a;
        b = last_b + static_cast<std::int64_t>(random.below(3)) - 1;
      }
      exact += static_cast<Int128>(a) * b;
      e.add_product(static_cast<double>(a), static_cast<double>(b));
      last_a = a;
      last_b = b;
    }
    ASSERT_EQ(e.sign(), sign_of(exact));
    ASSERT_NEAR(e.estimate(), static_cast<double>(exact),
                std::fabs(static_cast<double>(exact)) * 1e-15);
  }
}

TEST(ExactSum, ProductsOfSumsDistribute) {
  ExactSum a(1e10);
  a.add(1e-10);
  ExactSum b(1);
  b.add(-1e-20);
  ExactSum product;
  product.add_product(
      a, b);  // 1e10 + 1e-10 - 1e-10 - 1e-30, with 1e-10 and 1e10 * 1e-20 not quite equal
  ExactSum expected(1e10);
  expected.add(1e-10);
  expected.add_product(1e10, -1e-20);
  expected.add_product(1e-10, -1e-20);
  product.subtract(expected);
  EXPECT_EQ(product.sign(), 0);
}

}  // namespace
}  // namespace sightline::accel::geometry
