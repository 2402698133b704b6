// Changes sessions at random, message by message and field by field.
#include "tests/fuzz/service/mutate.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace sightline::tests {
namespace {

namespace pb = google::protobuf;

constexpr std::size_t kMaxMessages = 20;
constexpr std::size_t kMaxText = 70'000;
/// All values of enumerations, HitField having most, and an unknown one.
constexpr std::uint64_t kEnumValues = 17;

std::uint64_t any_integer(Random& random) {
  constexpr std::array<std::uint64_t, 14> kOdd{0,
                                               1,
                                               2,
                                               3,
                                               512,
                                               4096,
                                               16384,
                                               65536,
                                               0x7fffffff,
                                               1u << 31,
                                               0xffffffff,
                                               std::uint64_t{1} << 63,
                                               ~std::uint64_t{0},
                                               ~std::uint64_t{1}};
  return random.below(4) == 0 ? random.next() : kOdd[random.below(kOdd.size())];
}

double any_number(Random& random) {
  using Limits = std::numeric_limits<double>;
  constexpr std::array<double, 8> kOdd{
      0, -0.0, 1, -1, 1e300, 5e-324, Limits::infinity(), Limits::quiet_NaN()};
  return random.below(2) == 0 ? random.uniform(-10, 10) : kOdd[random.below(kOdd.size())];
}

/// Of a byte of `text`, or its end.
std::size_t any_offset(const std::string& text, Random& random) {
  return random.below(text.size() + 1);
}

void change_text(std::string& text, Random& random) {
  switch (random.below(8)) {
    case 0:
      text.clear();
      break;
    case 1:
      text.resize(any_offset(text, random));
      break;
    case 2:
      text.insert(any_offset(text, random), 1, static_cast<char>(random.next()));
      break;
    case 3:
      text.append(text.substr(any_offset(text, random)));
      break;
    case 4: {  // a number in a column
      const double number = any_number(random);
      const std::size_t at = text.size() / 8 == 0 ? 0 : 8 * random.below(text.size() / 8);
      const std::size_t size = std::min<std::size_t>(8, text.size() - at);
      text.replace(at, size, reinterpret_cast<const char*>(&number), size);
      break;
    }
    case 5:
      text.append(random.below(300), 'x');
      break;
    case 6:
      if (random.below(20) == 0) text.append(random.below(kMaxText), '\x80');
      break;
    default:
      if (!text.empty()) text[random.below(text.size())] ^= static_cast<char>(1 << random.below(8));
  }
  if (text.size() > kMaxText) text.resize(kMaxText);
}

void change_message(pb::Message& message, Random& random);

/// `index`: of a repeated field, or -1.
void change_value(pb::Message& message, const pb::FieldDescriptor& field, int index,
                  Random& random) {
  const pb::Reflection& reflection = *message.GetReflection();
  const auto set = [&](auto single, auto repeated, auto value) {
    if (index < 0) (reflection.*single)(&message, &field, value);
    if (index >= 0) (reflection.*repeated)(&message, &field, index, value);
  };
  using R = pb::Reflection;
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return set(&R::SetInt32, &R::SetRepeatedInt32,
                 static_cast<std::int32_t>(any_integer(random)));
    case pb::FieldDescriptor::CPPTYPE_INT64:
      return set(&R::SetInt64, &R::SetRepeatedInt64,
                 static_cast<std::int64_t>(any_integer(random)));
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      return set(&R::SetUInt32, &R::SetRepeatedUInt32,
                 static_cast<std::uint32_t>(any_integer(random)));
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      return set(&R::SetUInt64, &R::SetRepeatedUInt64, any_integer(random));
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return set(&R::SetDouble, &R::SetRepeatedDouble, any_number(random));
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return set(&R::SetFloat, &R::SetRepeatedFloat, static_cast<float>(any_number(random)));
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return set(&R::SetBool, &R::SetRepeatedBool, random.below(2) == 0);
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      return set(&R::SetEnumValue, &R::SetRepeatedEnumValue,
                 static_cast<int>(random.below(kEnumValues)));
    case pb::FieldDescriptor::CPPTYPE_STRING: {
      std::string text = index < 0 ? reflection.GetString(message, &field)
                                   : reflection.GetRepeatedString(message, &field, index);
      change_text(text, random);
      if (index < 0) return reflection.SetString(&message, &field, std::move(text));
      return reflection.SetRepeatedString(&message, &field, index, std::move(text));
    }
    case pb::FieldDescriptor::CPPTYPE_MESSAGE:
      return change_message(index < 0 ? *reflection.MutableMessage(&message, &field)
                                      : *reflection.MutableRepeatedMessage(&message, &field, index),
                            random);
  }
}

void add_element(pb::Message& message, const pb::FieldDescriptor& field, Random& random) {
  const pb::Reflection& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_MESSAGE: {
      pb::Message& added = *reflection.AddMessage(&message, &field);
      const int before = reflection.FieldSize(message, &field) - 1;
      if (before > 0) {
        const auto copied = static_cast<int>(random.below(static_cast<std::uint64_t>(before)));
        added.CopyFrom(reflection.GetRepeatedMessage(message, &field, copied));
      }
      return;
    }
    case pb::FieldDescriptor::CPPTYPE_STRING:
      return reflection.AddString(&message, &field, "");
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      return reflection.AddUInt64(&message, &field, any_integer(random));
    case pb::FieldDescriptor::CPPTYPE_INT64:
      return reflection.AddInt64(&message, &field, static_cast<std::int64_t>(any_integer(random)));
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.AddDouble(&message, &field, any_number(random));
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      return reflection.AddEnumValue(&message, &field, static_cast<int>(random.below(kEnumValues)));
    default:  // no request has such a field
      return;
  }
}

void change_repeated(pb::Message& message, const pb::FieldDescriptor& field, Random& random) {
  const pb::Reflection& reflection = *message.GetReflection();
  const int size = reflection.FieldSize(message, &field);
  if (size == 0 || random.below(4) == 0) return add_element(message, field, random);
  const auto index = static_cast<int>(random.below(static_cast<std::uint64_t>(size)));
  switch (random.below(6)) {
    case 0:
      return reflection.RemoveLast(&message, &field);
    case 1:
      return reflection.SwapElements(&message, &field, index, size - 1);
    default:
      return change_value(message, field, index, random);
  }
}

void change_message(pb::Message& message, Random& random) {
  const pb::Descriptor& type = *message.GetDescriptor();
  if (type.field_count() == 0) return;
  const pb::FieldDescriptor& field =
      *type.field(static_cast<int>(random.below(static_cast<std::uint64_t>(type.field_count()))));
  if (field.is_repeated()) return change_repeated(message, field, random);
  if (random.below(16) == 0) return message.GetReflection()->ClearField(&message, &field);
  change_value(message, field, -1, random);
}

void change_call(FuzzCall& call, Random& random) {
  if (call.messages.empty() || (random.below(16) == 0 && call.messages.size() < kMaxMessages)) {
    call.messages.push_back(call.messages.empty() ? "" : call.messages.back());
    return;
  }
  std::string& message = call.messages[random.below(call.messages.size())];
  const auto typed = random.below(8) == 0 ? nullptr : parse(call, message);
  if (!typed) return change_text(message, random);
  change_message(*typed, random);
  message = typed->SerializePartialAsString();
}

}  // namespace

void mutate(Session& session, Random& random) {
  if (session.empty()) session = example_sessions()[random.below(example_sessions().size())];
  FuzzCall& call = session[random.below(session.size())];
  switch (random.below(16)) {
    case 0:
      call.method = static_cast<std::uint8_t>(random.below(methods().size()));
      break;
    case 1:
      std::swap(call, session.back());
      break;
    case 2:
      session.push_back(FuzzCall(call));
      break;
    case 3:
      if (session.size() > 1) session.pop_back();
      break;
    default:
      change_call(call, random);
  }
}

}  // namespace sightline::tests
