// Examples in protobuf text format, data/*.textproto: each parses, keeps within the ranges its
// fields' comments state, and together they set every field of every message.
#include <doctest/doctest.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "hapticd/v1/scene.pb.h"
#include "tests/protocol/field_comment.h"
#include "tests/protocol/message_walk.h"
#include "tests/protocol/schema.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

const std::filesystem::path kData = HAPTICD_SOURCE_DIR "/tests/protocol/data";

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  REQUIRE(file.good());
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The message an example holds, of the type its second line names.
std::unique_ptr<pb::Message> parse_example(const std::filesystem::path& path) {
  CAPTURE(path.filename().string());
  const std::string text = text_of_file(path);
  std::smatch match;
  REQUIRE(std::regex_search(text, match, std::regex("\n# proto-message: ([\\w.]+)\n")));
  const auto* type = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(match[1]);
  REQUIRE(type != nullptr);
  std::unique_ptr<pb::Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(type)->New());
  REQUIRE(pb::TextFormat::ParseFromString(text, message.get()));
  return message;
}

std::vector<std::filesystem::path> examples() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(kData)) {
    if (entry.path().extension() == ".textproto") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// Numbers of a field that is a number, alone or repeated.
std::vector<double> numbers_of(const pb::Message& message, const pb::FieldDescriptor& field) {
  std::string text;
  if (field.is_repeated()) {
    const int count = message.GetReflection()->FieldSize(message, &field);
    for (int i = 0; i < count; ++i) {
      std::string one;
      pb::TextFormat::PrintFieldValueToString(message, &field, i, &one);
      text += one + ' ';
    }
  } else {
    pb::TextFormat::PrintFieldValueToString(message, &field, -1, &text);
  }
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number = 0.0; stream >> number;) numbers.push_back(number);
  return numbers;
}

TEST_CASE("the examples together set every field of every message") {
  std::set<std::string> unset;
  for (const pb::Descriptor* type : message_descriptors()) {
    for (const pb::FieldDescriptor* field : fields_of(*type)) unset.insert(field->full_name());
  }
  const auto mark = [&](const pb::Message& /*message*/, const pb::FieldDescriptor& field) {
    unset.erase(field.full_name());
  };
  for (const auto& path : examples()) for_each_set_field(*parse_example(path), mark);
  for (const std::string& name : unset) CHECK_MESSAGE(false, name << " is in no example");
}

TEST_CASE("every number of the examples is in the range its field's comment states") {
  const CommentedSchema schema;
  int checked = 0;
  for (const auto& path : examples()) {
    CAPTURE(path.filename().string());
    const auto check_range = [&](const pb::Message& message, const pb::FieldDescriptor& field) {
      const std::string range = range_part(schema.of(field));
      CAPTURE(field.full_name());
      CAPTURE(range);
      if (field.message_type() != nullptr && holds_numbers(field)) {
        // A Quantity: the range is that of the field that holds it.
        const pb::Message& quantity = message.GetReflection()->GetMessage(message, &field);
        const auto* value = quantity.GetDescriptor()->FindFieldByName("value");
        for (const double number : numbers_of(quantity, *value)) {
          CHECK(in_range(range, number) == true);
          ++checked;
        }
      } else if (is_number(field)) {
        for (const double number : numbers_of(message, field)) {
          CHECK(in_range(range, number) == true);
          ++checked;
        }
      }
    };
    for_each_set_field(*parse_example(path), check_range);
  }
  CHECK(checked > 500);
}

TEST_CASE("printing an example as text and parsing it again loses nothing") {
  for (const auto& path : examples()) {
    CAPTURE(path.filename().string());
    const std::unique_ptr<pb::Message> message = parse_example(path);
    std::string text;
    REQUIRE(pb::TextFormat::PrintToString(*message, &text));
    const std::unique_ptr<pb::Message> again(message->New());
    REQUIRE(pb::TextFormat::ParseFromString(text, again.get()));
    ValueMap before;
    ValueMap after;
    add_values(*message, "", before);
    add_values(*again, "", after);
    CHECK(before == after);
  }
}

TEST_CASE("in the minimal scene no feature is present, in the full scene all are") {
  const auto minimal = parse_example(kData / "minimal_scene.textproto");
  const auto full = parse_example(kData / "full_scene.textproto");
  for (const std::string feature :
       {"vibration", "friction", "lateral_force", "torque", "modes", "tones"}) {
    CAPTURE(feature);
    const auto* field = v1::Scene::descriptor()->FindFieldByName(feature);
    REQUIRE(field != nullptr);
    CHECK_FALSE(minimal->GetReflection()->HasField(*minimal, field));
    CHECK(full->GetReflection()->HasField(*full, field));
  }
}

TEST_CASE("a number left out of a scene differs from one written as 0") {
  v1::Scene scene;
  REQUIRE(pb::TextFormat::ParseFromString("strings { } strings { tension_n: 0 }", &scene));
  CHECK_FALSE(scene.strings(0).has_tension_n());
  REQUIRE(scene.strings(1).has_tension_n());
  CHECK(scene.strings(1).tension_n() == 0.0);
}

}  // namespace
}  // namespace hapticd::test
