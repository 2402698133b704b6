// Sine and cosine by Taylor's series about the nearest multiple of a right angle.
#include "proto/rays/sine_cosine.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace sightline::proto::rays {
namespace {

/// A right angle is the sum of these. The products of the first two and a small integer are exact.
constexpr std::array kRightAngle{0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e037073p-69};
constexpr double kRightAnglesPerRadian = 0x1.45f306dc9c883p-1;

/// Element k is 1 / (k (k + 1)), the quotient of two terms of a series.
constexpr std::array kQuotients = [] {
  std::array<double, 18> quotients{};
  for (std::size_t k = 1; k < quotients.size(); ++k)
    quotients[k] = 1 / static_cast<double>(k * (k + 1));
  return quotients;
}();

/// The series of the sine, divided by x, from k = 2, of the cosine from k = 1; square = x^2, where
/// |x| <= pi / 4. The first term left out is below 2^-53 times the sum.
double series(double square, std::size_t k) {
  double sum = 1;
  for (std::size_t terms = 8; terms-- > 0;) sum = 1 - square * kQuotients[k + 2 * terms] * sum;
  return sum;
}

}  // namespace

SineCosine sine_cosine(double angle) {
  const double turns = std::floor(angle * kRightAnglesPerRadian + 0.5);
  double rest = angle;
  for (const double part : kRightAngle) rest -= turns * part;
  const double square = rest * rest;
  const double sine = rest * series(square, 2);
  const double cosine = series(square, 1);
  switch (static_cast<int>(turns) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace sightline::proto::rays
