// How much memory a message takes when it is read.
#pragma once

#include <google/protobuf/descriptor.h>

#include <cstdint>
#include <string_view>

namespace sightline::server::durable {

/// About the most bytes that a message of this type takes when it is read, together with what is
/// made of it: a number of one byte becomes one of eight, twice. Bytes that are no message count up
/// to the first that is wrong. Cost: a walk over the fields, without arrays and strings.
std::uint64_t bytes_when_read(const google::protobuf::Descriptor& type, std::string_view message);

}  // namespace sightline::server::durable
