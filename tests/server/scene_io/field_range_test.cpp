// Every number of a scene is refused just outside the range its comment promises, and taken at its
// bounds. Truth: the comments, as the tests of the protocol read them.
#include <doctest/doctest.h>
#include <google/protobuf/message.h>

#include <cmath>
#include <functional>
#include <limits>
#include <regex>

#include "proto/wire/field_table.h"
#include "tests/protocol/field_comment.h"
#include "tests/server/scene_io/full_scene.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

/// A number of the full scene, where it is.
struct NumberField {
  std::string path;  ///< of the first element where it is repeated
  const pb::FieldDescriptor& field;
  pb::Message& owner;
};

void set_number(const NumberField& number, double value) {
  const pb::Reflection& r = *number.owner.GetReflection();
  const bool real = number.field.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE;
  if (number.field.is_repeated()) {
    r.SetRepeatedDouble(&number.owner, &number.field, 0, value);
  } else if (real) {
    r.SetDouble(&number.owner, &number.field, value);
  } else {
    r.SetUInt32(&number.owner, &number.field, static_cast<std::uint32_t>(value));
  }
}

/// Calls visit for every number of `message` and below.
// NOLINTNEXTLINE(misc-no-recursion, readability-function-cognitive-complexity): a schema is a tree
void for_each_number(pb::Message& message, const std::string& path,
                     const std::function<void(const NumberField&)>& visit) {
  const pb::Reflection& r = *message.GetReflection();
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const std::string here = path.empty() ? field.name() : path + "." + field.name();
    const int count = field.is_repeated() ? r.FieldSize(message, &field) : 1;
    if (field.message_type() == nullptr) {
      if (holds_numbers(field) && count > 0) {
        visit({field.is_repeated() ? here + "[0]" : here, field, message});
      }
      continue;
    }
    if (!field.is_repeated() && !r.HasField(message, &field)) continue;
    for (int k = 0; k < count; ++k) {
      pb::Message& below = field.is_repeated() ? *r.MutableRepeatedMessage(&message, &field, k)
                                               : *r.MutableMessage(&message, &field);
      for_each_number(below, field.is_repeated() ? here + "[" + std::to_string(k) + "]" : here,
                      visit);
    }
  }
}

/// The bounds of "[a, b)".
struct Bounds {
  double low;
  double high;
  bool low_in;
  bool high_in;
};

Bounds bounds_of(const std::string& range) {
  static const std::regex form(R"(([\[(])([-+.\de]+), ([-+.\de]+)([\])]))");
  std::smatch match;
  REQUIRE_MESSAGE(std::regex_match(range, match, form), range);
  return {std::stod(match[2]), std::stod(match[3]), match[1] == "[", match[4] == "]"};
}

/// Values at and around the bounds.
std::vector<double> probes(const Bounds& bounds, bool real) {
  if (!real) return {bounds.low, bounds.high, bounds.low - 1.0, bounds.high + 1.0};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {bounds.low,
          bounds.high,
          std::nextafter(bounds.low, -kInfinity),
          std::nextafter(bounds.high, kInfinity),
          -kInfinity,
          kInfinity,
          std::numeric_limits<double>::quiet_NaN()};
}

}  // namespace

TEST_CASE("the full scene loads, and uses every message that a scene can have") {
  const LoadResult result = load_inline(full_scene_text());
  INFO(list(result.problems));
  CHECK(result.loaded != nullptr);
  v1::Scene scene = full_scene();
  std::vector<std::string> seen;
  for_each_number(scene, "",
                  [&](const NumberField& number) { seen.push_back(number.field.full_name()); });
  const CommentedSchema schema;
  for (const wire::FieldRow& row : wire::field_table()) {
    const bool number = row.range.starts_with("[") || row.range.starts_with("(");
    const std::string_view message = row.field.substr(0, row.field.find('.'));
    if (!number || message == "Twist" || message == "AutomaticQuality") continue;
    if (message == "Modes") continue;  // what wave was before it
    CAPTURE(row.field);
    CHECK(std::find(seen.begin(), seen.end(), "hapticd.v1." + std::string(row.field)) !=
          seen.end());
  }
}

TEST_CASE("every number of a scene is refused outside the range of its comment, and only there") {
  const CommentedSchema schema;
  v1::Scene scene = full_scene();
  int numbers = 0;
  for_each_number(scene, "", [&](const NumberField& number) {
    const std::string range = range_part(schema.of(number.field));
    CAPTURE(number.path);
    CAPTURE(range);
    const bool real = number.field.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE;
    // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): set_number changes the scene
    const v1::Scene untouched = scene;
    for (const double value : probes(bounds_of(range), real)) {
      if (!real && value < 0.0) continue;
      CAPTURE(value);
      set_number(number, value);
      const LoadResult result = load_inline(print_scene(scene));
      const std::string printed = list(result.problems);
      CAPTURE(printed);
      const bool inside = *in_range(range, value);
      const SceneProblem* fault = find_fault(result.problems, number.path);
      const bool refused = fault != nullptr && fault->message.find(range) != std::string::npos;
      CHECK(refused != inside);
      if (refused) CHECK(fault->line > 0);
    }
    ++numbers;
    // Restores the value without moving what the visit looks at.
    for_each_number(const_cast<v1::Scene&>(untouched), "", [&](const NumberField& old) {
      if (old.path != number.path) return;
      const pb::Reflection& r = *old.owner.GetReflection();
      if (old.field.is_repeated()) {
        set_number(number, r.GetRepeatedDouble(old.owner, &old.field, 0));
      } else {
        set_number(number,
                   real ? r.GetDouble(old.owner, &old.field) : r.GetUInt32(old.owner, &old.field));
      }
    });
  });
  CHECK(numbers > 60);
}

TEST_CASE("what a scene leaves out is filled in with the default of its comment") {
  const CommentedSchema schema;
  const LoadResult result = load_inline(
      "name: \"bare\" tools { name: \"t\" parts { name: \"p\" shape { spheres { centre_m: [0, 0, "
      "0] radius_m: 0.01 } } } } strings { name: \"s\" p_wa_m: [-1, 9, 0] p_wb_m: [1, 9, 0] } "
      "vibration {} friction { coefficient: 0.1 } wave {} tones {}");
  REQUIRE_MESSAGE(result.loaded != nullptr, list(result.problems));
  int checked = 0;
  for_each_number(result.loaded->message, "", [&](const NumberField& number) {
    const std::string absence = absence_part(schema.of(number.field));
    std::smatch match;
    static const std::regex form(R"(default ([-+.\de]+)(,.*)?)");
    if (!std::regex_match(absence, match, form) || number.field.is_repeated()) return;
    // A choice of several has one default; the others stay unset.
    const pb::Reflection& r = *number.owner.GetReflection();
    if (number.field.has_presence() && !r.HasField(number.owner, &number.field)) return;
    CAPTURE(number.path);
    const bool real = number.field.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE;
    const double value =
        real ? r.GetDouble(number.owner, &number.field) : r.GetUInt32(number.owner, &number.field);
    CHECK(value == std::stod(match[1]));
    ++checked;
  });
  CHECK(checked > 25);
}

}  // namespace hapticd::test
