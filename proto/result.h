// Errors as values. Client and server share the codes, which are those of gRPC.
#pragma once

#include <cassert>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

namespace sightline {

/// The status codes of gRPC with their numbers, without `OK`.
enum class Code : std::uint8_t {
  kCancelled = 1,
  kUnknown,
  kInvalidArgument,
  kDeadlineExceeded,
  kNotFound,
  kAlreadyExists,
  kPermissionDenied,
  kResourceExhausted,
  kFailedPrecondition,
  kAborted,
  kOutOfRange,
  kUnimplemented,
  kInternal,
  kUnavailable,
  kDataLoss,
  kUnauthenticated,
};

/// The name of a code as gRPC writes it, e.g. "NOT_FOUND".
constexpr const char* name_of(Code code) {
  constexpr const char* kNames[] = {
      "CANCELLED",         "UNKNOWN",       "INVALID_ARGUMENT",  "DEADLINE_EXCEEDED",
      "NOT_FOUND",         "ALREADY_EXISTS", "PERMISSION_DENIED", "RESOURCE_EXHAUSTED",
      "FAILED_PRECONDITION", "ABORTED",     "OUT_OF_RANGE",      "UNIMPLEMENTED",
      "INTERNAL",          "UNAVAILABLE",   "DATA_LOSS",         "UNAUTHENTICATED"};
  return kNames[static_cast<int>(code) - static_cast<int>(Code::kCancelled)];
}

struct Error {
  Code code = Code::kUnknown;
  std::string message;  ///< For people: what was wrong, the value, the limit.
  std::string reason;   ///< For programs: UPPER_SNAKE_CASE, stable, e.g. "NODE_CYCLE"; empty: none.
};

/// Either a value or an Error. Asserts that the value of an error is not read.
template <class T>
class [[nodiscard]] Result {
 public:
  Result()
    requires std::is_same_v<T, std::monostate>
  = default;
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& operator*() & { return assert(ok()), *std::get_if<0>(&state_); }
  const T& operator*() const& { return assert(ok()), *std::get_if<0>(&state_); }
  T&& operator*() && { return assert(ok()), std::move(*std::get_if<0>(&state_)); }
  T* operator->() { return &**this; }
  const T* operator->() const { return &**this; }
  const Error& error() const { return assert(!ok()), *std::get_if<1>(&state_); }

 private:
  std::variant<T, Error> state_;
};

/// The result of an operation that returns no value but may fail. Status() is success.
using Status = Result<std::monostate>;

}  // namespace sightline
