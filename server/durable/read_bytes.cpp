// How much memory a message takes when it is read.
#include "server/durable/read_bytes.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

namespace sightline::server::durable {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

/// Bytes of a message, as protobuf and as we hold it.
constexpr std::uint64_t kPerMessage = 768;
/// A string is copied once; in protobuf it is an object of its own.
constexpr std::uint64_t kPerString = 64;
constexpr std::uint64_t kCopies = 2;
/// Bytes of a number that is one of many.
constexpr std::uint64_t kPerNumber = 2 * sizeof(std::uint64_t);
/// Protobuf refuses what is nested deeper.
constexpr int kMostDeep = 100;

std::uint64_t bytes_of_part(const FieldDescriptor* field, std::string_view part, int depth);

std::uint64_t bytes_of_message(const Descriptor& type, std::string_view message, int depth) {
  std::uint64_t bytes = kPerMessage;
  CodedInputStream in(reinterpret_cast<const std::uint8_t*>(message.data()),
                      static_cast<int>(message.size()));
  for (std::uint32_t tag = in.ReadTag(); tag != 0; tag = in.ReadTag()) {
    if (WireFormatLite::GetTagWireType(tag) != WireFormatLite::WIRETYPE_LENGTH_DELIMITED) {
      if (!WireFormatLite::SkipField(&in, tag)) break;
      bytes += kPerNumber;
      continue;
    }
    std::uint32_t size = 0;
    if (!in.ReadVarint32(&size)) break;
    const auto at = static_cast<std::size_t>(in.CurrentPosition());
    if (size > message.size() - at) break;
    bytes += bytes_of_part(type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag)),
                           message.substr(at, size), depth);
    if (!in.Skip(static_cast<int>(size))) break;
  }
  return bytes;
}

/// `field`: null for an unknown one, which is kept as it is.
std::uint64_t bytes_of_part(const FieldDescriptor* field, std::string_view part, int depth) {
  if (field == nullptr) return kPerString + kCopies * part.size();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return depth == kMostDeep ? 0 : bytes_of_message(*field->message_type(), part, depth + 1);
    case FieldDescriptor::CPPTYPE_STRING:
    case FieldDescriptor::CPPTYPE_DOUBLE:
    case FieldDescriptor::CPPTYPE_FLOAT:
      return kPerString + kCopies * part.size();
    default:
      return kPerNumber * part.size();
  }
}

}  // namespace

std::uint64_t bytes_when_read(const Descriptor& type, std::string_view message) {
  return bytes_of_message(type, message, 0);
}

}  // namespace sightline::server::durable
