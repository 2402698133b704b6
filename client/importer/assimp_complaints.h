// What Assimp logs while it reads a file. Internal to the importer.
#pragma once

#include <assimp/LogStream.hpp>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::client::importer {

/// Collects Assimp's errors and warnings as long as it lives, each sentence once. Leaves out those
/// about looks, and those that do not say that the scene differs. There is one at a time.
class AssimpComplaints {
 public:
  AssimpComplaints();
  AssimpComplaints(const AssimpComplaints&) = delete;
  AssimpComplaints& operator=(const AssimpComplaints&) = delete;
  ~AssimpComplaints();

  /// The first ones, and how many there are beside them.
  std::vector<std::string> take();

 private:
  struct Stream final : Assimp::LogStream {
    void write(const char* text) override;
    std::vector<std::string> lines;
    std::size_t more = 0;
  };

  Stream stream_;
};

/// The text on one line.
std::string one_line(std::string_view text);

}  // namespace sightline::client::importer
