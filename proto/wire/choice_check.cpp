// See choice_check.h.
#include "proto/wire/choice_check.h"

#include <vector>

namespace hapticd::wire {
namespace {

namespace pb = google::protobuf;
using Kind = pb::FieldDescriptor::CppType;

/// In element `i` of a field, or in the field itself where it is no list; the path of the field is
/// left out.
// NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
std::optional<UnknownChoice> unknown_in(const pb::Message& holder, const pb::FieldDescriptor& field,
                                        int i) {
  const pb::Reflection& r = *holder.GetReflection();
  if (field.cpp_type() == Kind::CPPTYPE_MESSAGE) {
    return unknown_choice(field.is_repeated() ? r.GetRepeatedMessage(holder, &field, i)
                                              : r.GetMessage(holder, &field));
  }
  if (field.cpp_type() != Kind::CPPTYPE_ENUM) return std::nullopt;
  const int number = field.is_repeated() ? r.GetRepeatedEnumValue(holder, &field, i)
                                         : r.GetEnumValue(holder, &field);
  if (field.enum_type()->FindValueByNumber(number) != nullptr) return std::nullopt;
  const pb::EnumDescriptor& type = *field.enum_type();
  return UnknownChoice{
      "", std::to_string(number) + " is not a value of " + type.name() + ". " + choices_of(type)};
}

}  // namespace

std::string choices_of(const pb::EnumDescriptor& type) {
  std::string text = "Choose ";
  for (int i = 0; i < type.value_count(); ++i) {
    if (type.value(i)->number() == 0) continue;
    text += type.value(i)->name() + (i + 1 < type.value_count() ? ", " : ".");
  }
  return text;
}

// NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
std::optional<UnknownChoice> unknown_choice(const pb::Message& message) {
  std::vector<const pb::FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? message.GetReflection()->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      std::optional<UnknownChoice> unknown = unknown_in(message, *field, i);
      if (!unknown) continue;
      const std::string at = field->is_repeated() ? "[" + std::to_string(i) + "]" : "";
      unknown->path = field->name() + at + (unknown->path.empty() ? "" : "." + unknown->path);
      return unknown;
    }
  }
  return std::nullopt;
}

}  // namespace hapticd::wire
