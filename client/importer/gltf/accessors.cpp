// Holds every offset against the bytes that there are, before any is read.
#include "client/importer/gltf/accessors.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace sightline::client::importer::gltf {
namespace {

constexpr std::uint64_t kMostElements = std::numeric_limits<std::uint32_t>::max() - 1;

Component component_of(const Item& item) {
  const std::uint64_t number = item.integer("componentType");
  for (const Component component :
       {Component::kInt8, Component::kUint8, Component::kInt16, Component::kUint16,
        Component::kUint32, Component::kFloat, Component::kDouble}) {
    if (static_cast<std::uint64_t>(component) == number) return component;
  }
  refuse("{}: componentType is {}, must be 5120, 5121, 5122, 5123, 5125, 5126 or 5130",
         item.where(), number);
}

std::size_t size_of(Component component) {
  switch (component) {
    case Component::kInt8:
    case Component::kUint8:
      return 1;
    case Component::kInt16:
    case Component::kUint16:
      return 2;
    case Component::kUint32:
    case Component::kFloat:
      return 4;
    case Component::kDouble:
      return 8;
  }
  return 0;
}

struct Type {
  std::string_view name;
  std::size_t width;
};
constexpr Type kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};

std::string_view name_of(std::size_t width) {
  return std::find_if(std::begin(kTypes), std::end(kTypes),
                      [&](const Type& type) { return type.width == width; })
      ->name;
}

template <class T>
double number(const char* bytes, bool is_normalized) {
  T value{};
  std::memcpy(&value, bytes, sizeof(T));
  const auto out = static_cast<double>(value);
  if (!is_normalized || !std::numeric_limits<T>::is_integer) return out;
  return std::max(out / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
}

std::uint32_t index_at(Component component, const char* bytes) {
  if (component == Component::kUint32) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes, sizeof(value));
    return value;
  }
  return static_cast<std::uint32_t>(value_of(component, false, bytes));
}

bool is_unsigned(Component component) {
  return component == Component::kUint8 || component == Component::kUint16 ||
         component == Component::kUint32;
}

}  // namespace

double value_of(Component component, bool is_normalized, const char* bytes) {
  switch (component) {
    case Component::kInt8:
      return number<std::int8_t>(bytes, is_normalized);
    case Component::kUint8:
      return number<std::uint8_t>(bytes, is_normalized);
    case Component::kInt16:
      return number<std::int16_t>(bytes, is_normalized);
    case Component::kUint16:
      return number<std::uint16_t>(bytes, is_normalized);
    case Component::kUint32:
      return number<std::uint32_t>(bytes, is_normalized);
    case Component::kFloat:
      return number<float>(bytes, is_normalized);
    case Component::kDouble:
      return number<double>(bytes, is_normalized);
  }
  return 0;
}

std::uint64_t Accessors::count(std::uint64_t index, std::string_view by) const {
  const Item item = document_.at("accessors", index, by);
  const std::uint64_t count = item.integer("count");
  if (count > kMostElements)
    refuse("{}: count is {}, the limit is {}", item.where(), count, kMostElements);
  return count;
}

// `item` is an accessor, or one of the two parts of a sparse one.
Accessors::Elements Accessors::elements(const Item& item, std::uint64_t count, std::uint64_t size) {
  const Buffers::View view = buffers_.view(item.integer("bufferView"), item.where());
  const std::uint64_t stride = view.stride == 0 ? size : view.stride;
  if (stride < size)
    refuse("{}: its elements have {} bytes, but the byteStride is {}", item.where(), size, stride);
  const std::uint64_t offset = item.integer("byteOffset", 0), bytes = view.bytes.size();
  const bool fits = count == 0 || (offset <= bytes && size <= bytes - offset &&
                                   count - 1 <= (bytes - offset - size) / stride);
  if (!fits) {
    refuse("{}: {} elements of {} bytes, {} apart, from byte {} on, but its buffer view has {}",
           item.where(), count, size, stride, offset, bytes);
  }
  const char* const first = count == 0 ? nullptr : view.bytes.data() + offset;
  return {first, static_cast<std::size_t>(stride), static_cast<std::size_t>(count)};
}

Accessors::Source Accessors::open(std::uint64_t index, std::string_view by, std::size_t width) {
  const Item item = document_.at("accessors", index, by);
  Source source;
  source.component = component_of(item);
  source.size = size_of(source.component);
  source.width = width;
  source.is_normalized = item.flag("normalized", false);
  const std::string type = item.text("type");
  if (type != name_of(width)) {
    refuse("{}: type is '{}', must be {} for {}", item.where(), type.substr(0, 40), name_of(width),
           by);
  }
  const std::uint64_t number = count(index, by);
  if (item.has("bufferView")) {
    source.elements = elements(item, number, source.size * width);
  } else {
    if (number > kMostZeros) {
      refuse("{}: it has {} elements and no bufferView, the limit is {}", item.where(), number,
             kMostZeros);
    }
    source.elements.count = static_cast<std::size_t>(number);
  }
  if (const auto sparse = item.object("sparse")) open_sparse(*sparse, source);
  return source;
}

void Accessors::open_sparse(const Item& sparse, Source& source) {
  const std::uint64_t count = sparse.integer("count");
  const auto indices = sparse.object("indices"), values = sparse.object("values");
  if (!indices || !values) refuse("{}: indices or values are missing", sparse.where());
  if (count > source.elements.count) {
    refuse("{}: count is {}, but the accessor has {} elements", sparse.where(), count,
           source.elements.count);
  }
  const Component component = component_of(*indices);
  if (!is_unsigned(component)) {
    refuse("{}: componentType is {}, must be 5121, 5123 or 5125", indices->where(),
           static_cast<unsigned>(component));
  }
  const Elements slots = elements(*indices, count, size_of(component));
  source.replaced = elements(*values, count, source.size * source.width);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t slot = index_at(component, slots.first + i * slots.stride);
    if (slot >= source.elements.count) {
      refuse("{}: index {} is {}, but the accessor has {} elements", sparse.where(), i, slot,
             source.elements.count);
    }
    source.slots.push_back(slot);
  }
}

Accessors::Indices Accessors::indices(std::uint64_t index, std::string_view by) {
  const Source source = open(index, by, 1);
  if (!is_unsigned(source.component)) {
    refuse("accessors[{}]: componentType is {}, must be 5121, 5123 or 5125 for {}", index,
           static_cast<unsigned>(source.component), by);
  }
  Indices out;
  out.greatest = source.size == 1   ? std::numeric_limits<std::uint8_t>::max()
                 : source.size == 2 ? std::numeric_limits<std::uint16_t>::max()
                                    : std::numeric_limits<std::uint32_t>::max();
  out.values.resize(source.elements.count);
  const auto put = [&](const Elements& from, std::size_t i, std::size_t slot) {
    out.values[slot] = index_at(source.component, from.first + i * from.stride);
  };
  for (std::size_t i = 0; i < out.values.size() && source.elements.first != nullptr; ++i)
    put(source.elements, i, i);
  for (std::size_t i = 0; i < source.slots.size(); ++i) put(source.replaced, i, source.slots[i]);
  return out;
}

}  // namespace sightline::client::importer::gltf
