// The statements of a STEP file. Internal to the importer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace sightline::client::importer {

struct Statement {
  std::string_view type, arguments;
};

/// Where `text` has this character outside of strings and, if `counts_depth`, of brackets; its size
/// if it has none.
std::size_t find_outside(std::string_view text, char wanted, bool counts_depth);

/// The number that a text like "#12" names. 0: it is no reference.
std::uint64_t number_of(std::string_view reference);

/// The first of arguments that commas part, which is removed from them.
std::string_view take_argument(std::string_view& rest);

/// The argument of this index, from 0. Empty: there are fewer.
std::string_view argument(const Statement& statement, std::size_t index);

/// The first three numbers of a list in an argument; those that are missing are 0.
std::array<double, 3> numbers_of(std::string_view list);

/// What is between the brackets of a list. Empty: it is none.
std::string_view inside_of(std::string_view list);

/// The statements by their numbers. They are valid as long as the text.
class Statements {
 public:
  explicit Statements(std::string_view step);

  const std::unordered_map<std::uint64_t, Statement>& all() const { return all_; }

  /// Numbers that two statements have, that one names and none has, or that stand in the string of
  /// another statement.
  std::vector<std::uint64_t> loose_ends() const;

  /// Nothing: there is no such statement.
  const Statement* find(std::string_view reference) const;

  /// Whether `is_met` is true for each statement of the list, and there is one.
  template <class IsMet>
  bool each_of(std::string_view list, const IsMet& is_met) const {
    std::string_view rest = inside_of(list);
    if (rest.empty()) return false;
    while (!rest.empty()) {
      const Statement* const statement = find(take_argument(rest));
      if (statement == nullptr || !is_met(*statement)) return false;
    }
    return true;
  }

 private:
  void add(std::string_view text);

  std::unordered_map<std::uint64_t, Statement> all_;
  std::vector<std::uint64_t> repeated_;
};

}  // namespace sightline::client::importer
