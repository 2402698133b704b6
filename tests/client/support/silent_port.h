// A port that accepts connections and never sends anything.
#pragma once

#include <string>

namespace sightline::tests {

class SilentPort {
 public:
  SilentPort();
  SilentPort(const SilentPort&) = delete;
  SilentPort& operator=(const SilentPort&) = delete;
  ~SilentPort();

  const std::string& endpoint() const { return endpoint_; }

 private:
  int socket_;
  std::string endpoint_;
};

}  // namespace sightline::tests
