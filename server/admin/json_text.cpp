// Whether a text is strict JSON, before messages are made of it.
#include "server/admin/json_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/exec/rpc_status.h"

namespace sightline::server::admin {
namespace {

/// The name that protobuf makes of a field's: "up_axis" becomes "upAxis".
std::string field_name(const std::string& key) {
  std::string name;
  bool upper = false;
  for (const char c : key) {
    if (c == '_') {
      upper = true;
      continue;
    }
    name += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    upper = false;
  }
  return name;
}

/// What the parser of nlohmann calls as it reads; it keeps nothing of the values.
class JsonChecker : public nlohmann::json_sax<nlohmann::json> {
 public:
  const Status& found() const { return found_; }

  bool null() override { return is_inside(); }
  bool boolean(bool) override { return is_inside(); }
  bool number_integer(number_integer_t) override { return is_inside(); }
  bool number_unsigned(number_unsigned_t) override { return is_inside(); }
  bool number_float(number_float_t, const string_t&) override { return is_inside(); }
  bool string(string_t&) override { return is_inside(); }
  bool binary(binary_t&) override { return is_inside(); }
  bool start_object(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return is_inside() && open(); }
  bool end_array() override { return close(); }

  bool key(string_t& key) override {
    if (names_.back().insert(field_name(key)).second) return true;
    return refuse(fmt::format("the name {} stands twice in one object", exec::quote(key)));
  }

  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception&) override {
    return refuse(fmt::format("the body is no JSON: byte {} does not fit", position));
  }

 private:
  bool is_inside() { return !names_.empty() || refuse("the body is JSON, but no object"); }

  bool open() {
    if (names_.size() == kMaxJsonDepth)
      return refuse(fmt::format("the body is nested more than {} deep", kMaxJsonDepth));
    names_.emplace_back();
    return true;
  }

  bool close() {
    names_.pop_back();
    return true;
  }

  bool refuse(std::string message) {
    found_ = exec::invalid_argument(std::move(message), "BAD_JSON");
    return false;
  }

  std::vector<std::set<std::string>> names_;  // of each open object; none of an array
  Status found_;
};

}  // namespace

Status check_json(std::string_view text) {
  JsonChecker checker;
  const bool good = nlohmann::json::sax_parse(text.begin(), text.end(), &checker);
  if (good || !checker.found()) return checker.found();
  return exec::invalid_argument("the body is no JSON", "BAD_JSON");
}

}  // namespace sightline::server::admin
