// Messages and errors as JSON: the methods that have it, and both ways of translation.
#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <string_view>

#include "proto/result.h"
#include "server/admin/http_server.h"

namespace sightline::server::admin {

/// The method of this name, such as "GetScene". Errors: kNotFound (there is none),
/// kUnimplemented (it is a stream).
Result<const google::protobuf::MethodDescriptor*> json_method(std::string_view name);

/// The bytes of the message of `type` that `text` has in the JSON mapping of proto3. Errors:
/// kInvalidArgument, also for a field that the message does not have.
Result<std::string> message_of_json(const google::protobuf::Descriptor& type,
                                    std::string_view text);

/// The JSON mapping of the message of `type` with these bytes, and a line's end. Fields that have
/// their default are left out. Errors: kInternal.
Result<std::string> json_of_message(const google::protobuf::Descriptor& type,
                                    const std::string& bytes);

/// {"error": {"code", "message", "reason"}} with the HTTP status that google.rpc.Code names for it.
HttpReply json_error(const Error& error);

}  // namespace sightline::server::admin
