// Every field says what it is, in which unit, shape and range, and what its absence means; the
// suffix of its name and its comment agree about the unit.
#include <doctest/doctest.h>

#include <array>
#include <regex>
#include <set>
#include <string>
#include <utility>

#include "tests/protocol/field_comment.h"
#include "tests/protocol/schema.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

/// Suffix of a field's name and the unit its comment must state; the longest match counts.
constexpr std::array<std::pair<const char*, const char*>, 33> kUnitOfSuffix{{
    {"_m", "m"},
    {"_um", "um"},
    {"_nanometres", "nanometres"},
    {"_n", "N"},
    {"_mn", "mN"},
    {"_n_m", "N m"},
    {"_n_per_m", "N/m"},
    {"_n_s_per_m", "N s/m"},
    {"_n_m_per_rad", "N m/rad"},
    {"_n_m_s_per_rad", "N m s/rad"},
    {"_rad", "rad"},
    {"_s", "s"},
    {"_per_s", "1/s"},
    {"_ms", "ms"},
    {"_us", "us"},
    {"_ns", "ns"},
    {"_hz", "Hz"},
    {"_m_per_s", "m/s"},
    {"_m_per_s2", "m/s^2"},
    {"_rad_per_s", "rad/s"},
    {"_kg", "kg"},
    {"_kg_m2", "kg m^2"},
    {"_kg_per_m", "kg/m"},
    {"_pa", "Pa"},
    {"_j", "J"},
    {"_cents", "cents"},
    {"_deg_c", "degC"},
    {"_e4", "1e-4"},
    {"bytes_per_s", "bytes/s"},
    {"_h_w", "N and N m"},
    {"_hash", "hash"},
    {"_id", "id"},
    {"_index", "index"},
}};

/// Units of numbers that count, number or compare.
const std::set<std::string> kUnitless{"1",
                                      "count",
                                      "id",
                                      "index",
                                      "tick",
                                      "ticks",
                                      "bits",
                                      "bytes",
                                      "level",
                                      "hash",
                                      "as the field",
                                      "as the holding field",
                                      "as the layout"};

/// Fields named after an option of the command line, scales, and a symbol that ends like a unit.
const std::set<std::string> kNamedOtherwise{"hapticd.v1.String.k_s",
                                            "hapticd.v1.Config.rate",
                                            "hapticd.v1.Config.max_force",
                                            "hapticd.v1.AxisMap.position_scale",
                                            "hapticd.v1.AxisMap.rotation_scale",
                                            "hapticd.v1.AxisMap.force_scale",
                                            "hapticd.v1.StringSounding.cents_per_s"};

std::string unit_of_name(const std::string& name) {
  std::string unit;
  std::size_t longest = 0;
  for (const auto& [suffix, its_unit] : kUnitOfSuffix) {
    const std::string ending = suffix;
    const bool match = name.size() >= ending.size() &&
                       name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
    if (match && ending.size() > longest) {
      longest = ending.size();
      unit = its_unit;
    }
  }
  return unit;
}

bool starts_with(const std::string& text, const std::string& start) {
  return text.rfind(start, 0) == 0;
}

template <class Check>
void for_each_field(Check check) {
  for (const pb::Descriptor* message : message_descriptors()) {
    for (const Field* field : fields_of(*message)) {
      CAPTURE(field->full_name());
      check(*field);
    }
  }
}

TEST_CASE("every field has a comment that ends in brackets, each part filled in") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    const FieldComment comment = schema.of(field);
    CHECK(comment.text.size() >= 4);
    CHECK(!comment.parts.empty());
    for (const std::string& part : comment.parts) CHECK(!part.empty());
  });
}

TEST_CASE("messages, enums and oneofs have comments") {
  const CommentedSchema schema;
  for (const pb::Descriptor* message : message_descriptors()) {
    CAPTURE(message->full_name());
    CHECK(schema.of(*message).size() >= 8);
    for (int i = 0; i < message->real_oneof_decl_count(); ++i) {
      CHECK(!schema.of(*message->oneof_decl(i)).parts.empty());
    }
  }
  for (const pb::EnumDescriptor* type : enum_descriptors()) {
    CAPTURE(type->full_name());
    CHECK(schema.of(*type).size() >= 8);
  }
}

TEST_CASE("every comment says what the field's absence means") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    const std::string absence = absence_part(schema.of(field));
    CAPTURE(absence);
    CHECK((starts_with(absence, "default") || starts_with(absence, "absent") ||
           starts_with(absence, "required") || starts_with(absence, "always")));
  });
}

TEST_CASE("numbers state unit, range and absence, repeated ones their shape too") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    if (!holds_numbers(field)) return;
    const FieldComment comment = schema.of(field);
    const bool many = field.is_repeated() || field.message_type() != nullptr;
    CHECK(comment.parts.size() == (many ? 4 : 3));
    CAPTURE(range_part(comment));
    CHECK(in_range(range_part(comment), 1.0).has_value());
  });
}

TEST_CASE("repeated texts, enums and messages state how many there may be") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    if (!field.is_repeated() || holds_numbers(field)) return;
    CHECK(schema.of(field).parts.size() == 2);
  });
}

TEST_CASE("texts say text, bytes say how many") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    if (field.is_repeated()) return;
    const std::string unit = unit_part(schema.of(field));
    if (field.type() == Field::TYPE_STRING) CHECK(unit == "text");
    if (field.type() == Field::TYPE_BYTES) {
      CHECK(std::regex_match(unit, std::regex(R"([\d.]+ bytes)")));
    }
  });
}

TEST_CASE("the unit in the comment is the one the field's name ends in") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    if (!holds_numbers(field)) return;
    const std::string unit = unit_part(schema.of(field));
    const std::string named = unit_of_name(field.name());
    CAPTURE(unit);
    if (kNamedOtherwise.count(field.full_name()) == 1) return;
    if (named.empty()) {
      CHECK(kUnitless.count(unit) == 1);
    } else {
      CHECK(unit == named);
    }
  });
}

TEST_CASE("a number whose default is not 0 can be told from 0") {
  const CommentedSchema schema;
  for_each_field([&](const Field& field) {
    if (!is_number(field) || field.is_repeated() || field.has_presence()) return;
    const std::string absence = absence_part(schema.of(field));
    CAPTURE(absence);
    CHECK(!starts_with(absence, "absent"));
    if (starts_with(absence, "default")) {
      CHECK(std::regex_match(absence, std::regex("default 0([: ].*)?")));
    }
  });
}

TEST_CASE("intervals in comments are read as written") {
  CHECK(in_range("[0, 1]", 0.0) == true);
  CHECK(in_range("(0, 1]", 0.0) == false);
  CHECK(in_range("[0, 1]", 1.0) == true);
  CHECK(in_range("[0, 1)", 1.0) == false);
  CHECK(in_range("[-1e7, 1e7]", -2e7) == false);
  CHECK(in_range(">= 1", 0.5) == false);
  CHECK(in_range("-1 or 1", 0.0) == false);
  CHECK(in_range("finite", 1e308) == true);
  CHECK(!in_range("somewhere", 0.0).has_value());
}

}  // namespace
}  // namespace hapticd::test
