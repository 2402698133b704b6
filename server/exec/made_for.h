// For whom a call within the process is made.
#pragma once

#include <string>
#include <string_view>

namespace sightline::server::exec {

/// The metadata by which a call of the process to itself names the peer that it is made for: a call
/// of the live page is one of the page's address. It counts only with a secret of the process.
inline constexpr const char* kMadeFor = "x-made-for";

/// The value of kMadeFor. `peer`: in the form of caller_of().
std::string made_for(std::string_view peer);

}  // namespace sightline::server::exec
