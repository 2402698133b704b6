// What a measurement was made with: machine, versions, command.
#pragma once

#include <cstdint>
#include <string>

namespace sightline::client::load {

struct Machine {
  std::string processor;  ///< its model, or empty
  int processors = 1;
  std::uint64_t memory_bytes = 0;
  std::string system;  ///< the kernel and its version
  std::string time;    ///< UTC, as 2026-01-31T12:00:00Z
};

/// The machine that this process runs on. Fields are empty where the system does not tell.
Machine this_machine();

}  // namespace sightline::client::load
