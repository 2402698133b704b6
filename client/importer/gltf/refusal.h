// Why a glTF file is not read. Internal to the importer.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace sightline::client::importer::gltf {

/// Thrown in this folder when the file is wrong or not understood. read_gltf makes an error of it.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <class... Values>
[[noreturn]] void refuse(fmt::format_string<Values...> text, Values&&... values) {
  throw Refusal(fmt::format(text, std::forward<Values>(values)...));
}

}  // namespace sightline::client::importer::gltf
