// See field_check.h.
#include "server/scene_io/field_check.h"

#include <google/protobuf/stubs/common.h>

#include <sstream>

#include "proto/wire/choice_check.h"
#include "proto/wire/field_table.h"

namespace hapticd {
namespace {

namespace pb = google::protobuf;
using Kind = pb::FieldDescriptor::CppType;

/// Most faults reported: a generated scene may have a million.
constexpr std::size_t kMaxFaults = 100;

/// A field of a message, where it is.
struct Place {
  const pb::Message& message;
  const pb::FieldDescriptor& field;
  std::string path;

  [[nodiscard]] const pb::Reflection& reflection() const { return *message.GetReflection(); }
  [[nodiscard]] int count() const {
    return field.is_repeated() ? reflection().FieldSize(message, &field) : 1;
  }
  /// Path of element i.
  [[nodiscard]] std::string at(int i) const {
    return field.is_repeated() ? path + "[" + std::to_string(i) + "]" : path;
  }
};

bool is_number(const pb::FieldDescriptor& field) {
  return field.cpp_type() == Kind::CPPTYPE_DOUBLE || field.cpp_type() == Kind::CPPTYPE_UINT32;
}

double number_at(const Place& place, int i) {
  const pb::Reflection& r = place.reflection();
  const bool real = place.field.cpp_type() == Kind::CPPTYPE_DOUBLE;
  if (!place.field.is_repeated()) {
    return real ? r.GetDouble(place.message, &place.field)
                : r.GetUInt32(place.message, &place.field);
  }
  return real ? r.GetRepeatedDouble(place.message, &place.field, i)
              : r.GetRepeatedUInt32(place.message, &place.field, i);
}

std::string in_words(double value) {
  std::ostringstream text;
  text.precision(12);
  text << value;
  return text.str();
}

class Check {
 public:
  // NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
  void message(const pb::Message& message, const std::string& path) {
    const pb::Descriptor& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count() && !full(); ++i) {
      const pb::FieldDescriptor& field = *type.field(i);
      const Place place{message, field, path.empty() ? field.name() : path + "." + field.name()};
      const bool absent = field.has_presence() && !place.reflection().HasField(message, &field);
      if (!absent) check(place);
    }
  }
  [[nodiscard]] SceneProblems take() && { return std::move(problems_); }

 private:
  [[nodiscard]] bool full() const { return problems_.size() >= kMaxFaults; }

  void fault(const std::string& path, std::string message, std::string remedy) {
    if (!full())
      problems_.push_back({false, "", 0, 0, path, std::move(message), std::move(remedy)});
  }

  // NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
  void check(const Place& place) {
    if (place.field.type() == pb::FieldDescriptor::TYPE_STRING) check_text(place);
    const wire::FieldRow* row =
        wire::find_row(place.field.containing_type()->name() + "." + place.field.name());
    if (row == nullptr) return;
    if (is_number(place.field)) {
      check_numbers(place, *row);
    } else if (place.field.cpp_type() == Kind::CPPTYPE_ENUM) {
      check_choice(place);
    } else {
      check_length(place, *row);
    }
    if (place.field.cpp_type() != Kind::CPPTYPE_MESSAGE) return;
    for (int i = 0; i < place.count() && !full(); ++i) {
      message(place.field.is_repeated()
                  ? place.reflection().GetRepeatedMessage(place.message, &place.field, i)
                  : place.reflection().GetMessage(place.message, &place.field),
              place.at(i));
    }
  }

  // Text format writes any byte; a Packet with a string that is not text is refused by whoever gets
  // it.
  void check_text(const Place& place) {
    const pb::Reflection& r = place.reflection();
    for (int i = 0; i < place.count() && !full(); ++i) {
      const std::string text = place.field.is_repeated()
                                   ? r.GetRepeatedString(place.message, &place.field, i)
                                   : r.GetString(place.message, &place.field);
      if (pb::internal::IsStructurallyValidUTF8(text)) continue;
      fault(place.at(i), "is not UTF-8 text", "Write it in UTF-8.");
    }
  }

  void check_numbers(const Place& place, const wire::FieldRow& row) {
    const auto range = wire::parse_interval(row.range);
    for (int i = 0; i < place.count() && range && !full(); ++i) {
      const double value = number_at(place, i);
      if (range->contains(value)) continue;
      std::string message = in_words(value) + " is not in " + std::string(row.range);
      if (row.unit != "1") message += " " + std::string(row.unit);
      fault(place.at(i), message, "");
    }
    if (!place.field.is_repeated()) return;
    const auto counted = wire::parse_interval(row.shape);
    const int wanted = row.shape.starts_with("4") ? 4 : 3;
    const bool any_multiple = row.shape.find(" n") == 1;
    const bool fits = counted        ? counted->contains(place.count())
                      : any_multiple ? place.count() % wanted == 0
                                     : place.count() == wanted;
    if (row.shape.starts_with("n") || fits) return;
    // An absent pose is the identity; what is required is asked for elsewhere.
    if (place.count() == 0) return;
    fault(place.path, std::to_string(place.count()) + " numbers",
          "Give " + std::string(row.shape) + ".");
  }

  void check_choice(const Place& place) {
    const pb::Reflection& r = place.reflection();
    for (int i = 0; i < place.count() && !full(); ++i) {
      const int value = place.field.is_repeated()
                            ? r.GetRepeatedEnumValue(place.message, &place.field, i)
                            : r.GetEnumValue(place.message, &place.field);
      if (place.field.enum_type()->FindValueByNumber(value) != nullptr) continue;
      fault(place.at(i),
            std::to_string(value) + " is not a value of " + place.field.enum_type()->name(),
            wire::choices_of(*place.field.enum_type()));
    }
  }

  void check_length(const Place& place, const wire::FieldRow& row) {
    // The range of a single message is that of the numbers in it, which its reader knows.
    const bool message = place.field.cpp_type() == Kind::CPPTYPE_MESSAGE;
    if (message && !place.field.is_repeated()) return;
    const auto range = wire::parse_interval(row.range);
    if (!range || (row.may_be_absent && place.field.is_repeated() && place.count() == 0)) return;
    const bool text = place.field.cpp_type() == Kind::CPPTYPE_STRING && !place.field.is_repeated();
    const double length =
        text ? static_cast<double>(place.reflection().GetString(place.message, &place.field).size())
             : place.count();
    if (range->contains(length)) return;
    fault(
        place.path,
        in_words(length) + (text ? " bytes long, not " : " of them, not ") + std::string(row.range),
        "");
  }

  SceneProblems problems_;
};

}  // namespace

SceneProblems check_fields(const pb::Message& message, const std::string& path) {
  Check check;
  check.message(message, path);
  return std::move(check).take();
}

}  // namespace hapticd
