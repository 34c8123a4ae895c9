// See choice_check.h.
#include "server/scene_io/choice_check.h"

#include <vector>

namespace hapticd {
namespace {

namespace pb = google::protobuf;
using Kind = pb::FieldDescriptor::CppType;

std::string in_words(int number, const pb::EnumDescriptor& type) {
  std::string text = std::to_string(number) + " is not a value of " + type.name() + ". Choose ";
  for (int i = 0; i < type.value_count(); ++i) {
    if (type.value(i)->number() == 0) continue;
    text += type.value(i)->name() + (i + 1 < type.value_count() ? ", " : ".");
  }
  return text;
}

class Search {
 public:
  // NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
  bool message(const pb::Message& message, const std::string& path) {
    std::vector<const pb::FieldDescriptor*> fields;
    message.GetReflection()->ListFields(message, &fields);
    for (const pb::FieldDescriptor* field : fields) {
      if (field->cpp_type() != Kind::CPPTYPE_ENUM && field->cpp_type() != Kind::CPPTYPE_MESSAGE) {
        continue;
      }
      if (this->field(message, *field, path.empty() ? field->name() : path + "." + field->name())) {
        return true;
      }
    }
    return false;
  }
  [[nodiscard]] std::optional<UnknownChoice> take() && { return std::move(found_); }

 private:
  // NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
  bool field(const pb::Message& holder, const pb::FieldDescriptor& field, const std::string& path) {
    const pb::Reflection& r = *holder.GetReflection();
    const bool is_enum = field.cpp_type() == Kind::CPPTYPE_ENUM;
    if (!field.is_repeated()) {
      return is_enum ? choice(r.GetEnumValue(holder, &field), field, path)
                     : message(r.GetMessage(holder, &field), path);
    }
    for (int i = 0; i < r.FieldSize(holder, &field); ++i) {
      const std::string at = path + "[" + std::to_string(i) + "]";
      if (is_enum ? choice(r.GetRepeatedEnumValue(holder, &field, i), field, at)
                  : message(r.GetRepeatedMessage(holder, &field, i), at)) {
        return true;
      }
    }
    return false;
  }

  bool choice(int number, const pb::FieldDescriptor& field, const std::string& path) {
    if (field.enum_type()->FindValueByNumber(number) != nullptr) return false;
    found_ = UnknownChoice{path, in_words(number, *field.enum_type())};
    return true;
  }

  std::optional<UnknownChoice> found_;
};

}  // namespace

std::optional<UnknownChoice> unknown_choice(const pb::Message& message) {
  Search search;
  search.message(message, "");
  return std::move(search).take();
}

}  // namespace hapticd
