// A server that answers casts without tracing, each after the same time: a truth for the load
// tester.
#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace sightline::tests::load {

class DelayService {
 public:
  /// On a free port of the loopback interface. All rays hit, at distance 1.
  explicit DelayService(std::chrono::microseconds delay);
  DelayService(const DelayService&) = delete;
  ~DelayService();

  std::string endpoint() const;

 private:
  class Calls;
  std::unique_ptr<Calls> calls_;
};

}  // namespace sightline::tests::load
