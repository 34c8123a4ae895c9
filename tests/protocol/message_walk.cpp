// Recursion over the descriptors. Not RT.
#include "tests/protocol/message_walk.h"

#include <google/protobuf/descriptor.h>

#include <cstring>
#include <vector>

namespace hapticd::test {

namespace pb = google::protobuf;

namespace {

/// The bits of `value` as a whole number.
template <class Unsigned, class Number>
std::string bits_of(Number value) {
  static_assert(sizeof(Unsigned) == sizeof(Number));
  Unsigned bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return std::to_string(bits);
}

/// The value of a singular field, or of element `i` of a repeated one (i < 0: singular).
std::string value_of(const pb::Message& message, const pb::FieldDescriptor& field, int i) {
  const pb::Reflection& r = *message.GetReflection();
  const pb::FieldDescriptor* f = &field;
  const bool one = i < 0;
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return text_of(one ? r.GetInt32(message, f) : r.GetRepeatedInt32(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_INT64:
      return text_of(one ? r.GetInt64(message, f) : r.GetRepeatedInt64(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      return text_of(one ? r.GetUInt32(message, f) : r.GetRepeatedUInt32(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      return text_of(one ? r.GetUInt64(message, f) : r.GetRepeatedUInt64(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return text_of(one ? r.GetDouble(message, f) : r.GetRepeatedDouble(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return text_of(one ? r.GetFloat(message, f) : r.GetRepeatedFloat(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return (one ? r.GetBool(message, f) : r.GetRepeatedBool(message, f, i)) ? "true" : "false";
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      return text_of(one ? r.GetEnumValue(message, f) : r.GetRepeatedEnumValue(message, f, i));
    case pb::FieldDescriptor::CPPTYPE_STRING:
      return one ? r.GetString(message, f) : r.GetRepeatedString(message, f, i);
    case pb::FieldDescriptor::CPPTYPE_MESSAGE:
      return "present";
  }
  return "";
}

}  // namespace

std::string text_of(double value) { return bits_of<std::uint64_t>(value); }
std::string text_of(float value) { return bits_of<std::uint32_t>(value); }
std::string text_of(std::int32_t value) { return std::to_string(value); }
std::string text_of(std::int64_t value) { return std::to_string(value); }
std::string text_of(std::uint32_t value) { return std::to_string(value); }
std::string text_of(std::uint64_t value) { return std::to_string(value); }

// NOLINTNEXTLINE(misc-no-recursion): messages nest a few levels deep and never contain themselves
void add_values(const pb::Message& message, const std::string& path, ValueMap& values) {
  const pb::Reflection& reflection = *message.GetReflection();
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int k = 0; k < type.field_count(); ++k) {
    const pb::FieldDescriptor* field = type.field(k);
    const bool is_message = field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE;
    const std::string name = path + field->name();
    if (field->is_repeated()) {
      for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
        const std::string element = name + '[' + std::to_string(i) + ']';
        values[element] = value_of(message, *field, i);
        if (is_message) {
          add_values(reflection.GetRepeatedMessage(message, field, i), element + '.', values);
        }
      }
    } else if (!field->has_presence() || reflection.HasField(message, field)) {
      values[name] = value_of(message, *field, -1);
      if (is_message) add_values(reflection.GetMessage(message, field), name + '.', values);
    }
  }
}

// NOLINTNEXTLINE(misc-no-recursion): messages nest a few levels deep and never contain themselves
void for_each_set_field(const pb::Message& message, const FieldVisitor& visit) {
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    visit(message, *field);
    if (field->message_type() == nullptr) continue;
    if (!field->is_repeated()) {
      for_each_set_field(reflection.GetMessage(message, field), visit);
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      for_each_set_field(reflection.GetRepeatedMessage(message, field, i), visit);
    }
  }
}

}  // namespace hapticd::test
