// See text_remedy.h.
#include "proto/hints/text_remedy.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/hints/nearest_name.h"

namespace hapticd::hints {
namespace {

namespace pb = google::protobuf;

/// What is quoted in `text` behind `before`; empty: nothing.
std::string_view quoted(std::string_view text, std::string_view before) {
  const std::size_t at = text.find(before);
  if (at == std::string_view::npos || text.substr(at + before.size(), 1) != "\"") return {};
  text.remove_prefix(at + before.size() + 1);
  return text.substr(0, text.find('"'));
}

/// The types of `root` and of all messages below it.
std::vector<const pb::Descriptor*> types_below(const pb::Descriptor& root) {
  std::vector<const pb::Descriptor*> types{&root};
  for (std::size_t next = 0; next < types.size(); ++next) {
    const pb::Descriptor& type = *types[next];
    for (int i = 0; i < type.field_count(); ++i) {
      const pb::Descriptor* below = type.field(i)->message_type();
      if (below == nullptr) continue;
      if (std::find(types.begin(), types.end(), below) == types.end()) types.push_back(below);
    }
  }
  return types;
}

std::string field_meant(const pb::Descriptor& root, std::string_view type, std::string_view name) {
  for (const pb::Descriptor* each : types_below(root)) {
    if (each->full_name() != type) continue;
    std::vector<std::string> names;
    names.reserve(static_cast<std::size_t>(each->field_count()));
    for (int i = 0; i < each->field_count(); ++i) names.push_back(each->field(i)->name());
    return did_you_mean(name, names);
  }
  return {};
}

/// Values of all fields of this name that have some, of whatever message.
std::vector<std::string> values_of(const pb::Descriptor& root, std::string_view name) {
  std::vector<std::string> names;
  for (const pb::Descriptor* type : types_below(root)) {
    const pb::FieldDescriptor* field = type->FindFieldByName(std::string(name));
    if (field == nullptr || field->enum_type() == nullptr) continue;
    for (int i = 0; i < field->enum_type()->value_count(); ++i) {
      const pb::EnumValueDescriptor& each = *field->enum_type()->value(i);
      const bool known = std::find(names.begin(), names.end(), each.name()) != names.end();
      if (each.number() != 0 && !known) names.push_back(each.name());
    }
  }
  return names;
}

/// `value` belongs to a field of this name.
std::string value_meant(const pb::Descriptor& root, std::string_view value, std::string_view name) {
  const std::vector<std::string> names = values_of(root, name);
  if (std::string meant = did_you_mean(value, names); !meant.empty()) return meant;
  // CLOCK_MODE_VIRTUAL is `virtual` on the command line.
  std::string end = "_";
  for (const char c : value) end += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  std::string choose;
  for (const std::string& each : names) {
    if (each.ends_with(end)) return " Did you mean " + each + "?";
    choose += (choose.empty() ? " Choose " : ", ") + each;
  }
  return choose.empty() ? choose : choose + ".";
}

}  // namespace

std::string text_remedy(const pb::Descriptor& root, const std::string& message) {
  using Rule = std::pair<std::string_view, std::string_view>;
  static constexpr std::array kForms{
      Rule{"Need space between number and identifier",
           " Write the number alone; the field's name or its description has the unit."},
      Rule{"Expected double, got: \"", " Write the number alone, without quotes and unit."},
      Rule{"Expected integer, got: \"", " Write the number alone, without quotes and unit."},
      Rule{"Expected identifier, got: ",
           " Lists are in [ ], messages in { }, and decimals have a point."},
      Rule{"Expected string, got: ", " Put the text in quotes."},
      Rule{"Expected integer or identifier, got: \"", " Write the name without quotes."},
      Rule{"Expected \":\", found ", " A field is written as NAME: VALUE, or NAME { FIELDS }."},
      Rule{"Expected \"{\", found ", " It has fields: write them as NAME { FIELDS }."}};
  std::string remedy;
  if (const std::string_view name = quoted(message, "has no field named "); !name.empty()) {
    remedy = field_meant(root, quoted(message, "Message type "), name);
  } else if (const std::string_view value = quoted(message, "Unknown enumeration value of ");
             !value.empty()) {
    remedy = value_meant(root, value, quoted(message, "for field "));
  } else {
    for (const auto& [beginning, form] : kForms) {
      if (remedy.empty() && message.starts_with(beginning)) remedy = form;
    }
  }
  return remedy.empty() ? remedy : remedy.substr(1);
}

}  // namespace hapticd::hints
