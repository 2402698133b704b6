// The numbers of a glTF file's accessors. Internal to the importer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "client/importer/gltf/buffers.h"
#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

/// The limit on the elements of an accessor without a buffer view, which takes no bytes of the
/// file.
inline constexpr std::uint64_t kMostZeros = std::uint64_t{1} << 24U;

/// The kind of a component, by its number in the format.
enum class Component : std::uint16_t {
  kInt8 = 5120,
  kUint8 = 5121,
  kInt16 = 5122,
  kUint16 = 5123,
  kUint32 = 5125,
  kFloat = 5126,
  kDouble = 5130,  ///< for KHR_accessor_float64
};

/// A component as the number that it means: an integer of a normalised accessor is a share of the
/// greatest one, from -1 or 0 to 1.
double value_of(Component component, bool is_normalized, const char* bytes);

class Accessors {
 public:
  /// Both must outlive this object.
  Accessors(const Document& document, Buffers& buffers) : document_(document), buffers_(buffers) {}

  /// All elements, with sparse ones put in. Refuses an accessor whose elements do not have
  /// kWidth components, and one that reaches beyond its bytes. `by`: who names it.
  template <std::size_t kWidth>
  std::vector<std::array<double, kWidth>> rows(std::uint64_t index, std::string_view by) {
    const Source source = open(index, by, kWidth);
    std::vector<std::array<double, kWidth>> out(source.elements.count);
    for (std::size_t i = 0; i < out.size() && source.elements.first != nullptr; ++i)
      read(source, source.elements, i, out[i].data());
    for (std::size_t i = 0; i < source.slots.size(); ++i)
      read(source, source.replaced, i, out[source.slots[i]].data());
    return out;
  }

  struct Indices {
    std::vector<std::uint32_t> values;
    std::uint32_t greatest = 0;  ///< the type's greatest, which the format reserves
  };
  /// Refuses numbers that are no unsigned integers.
  Indices indices(std::uint64_t index, std::string_view by);

  std::uint64_t count(std::uint64_t index, std::string_view by) const;

 private:
  struct Elements {
    const char* first = nullptr;  // none: zeros
    std::size_t stride = 0, count = 0;
  };
  struct Source {
    Component component = Component::kFloat;
    std::size_t size = 0;  // bytes of a component
    std::size_t width = 0;
    bool is_normalized = false;
    Elements elements;
    std::vector<std::uint32_t> slots;  // the slots of sparse elements
    Elements replaced;
  };

  Source open(std::uint64_t index, std::string_view by, std::size_t width);
  Elements elements(const Item& item, std::uint64_t count, std::uint64_t size);
  void open_sparse(const Item& sparse, Source& source);
  static void read(const Source& source, const Elements& from, std::size_t index, double* row) {
    const char* at = from.first + index * from.stride;
    for (std::size_t k = 0; k < source.width; ++k, at += source.size)
      row[k] = value_of(source.component, source.is_normalized, at);
  }

  const Document& document_;
  Buffers& buffers_;
};

}  // namespace sightline::client::importer::gltf
