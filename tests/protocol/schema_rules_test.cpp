// What holds for every message and enum of the schema, checked on the descriptors.
#include <doctest/doctest.h>
#include <google/protobuf/descriptor.pb.h>

#include <cctype>
#include <set>
#include <string>

#include "tests/protocol/schema.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

/// CamelCase to UPPER_SNAKE_CASE.
std::string upper_snake(const std::string& name) {
  std::string result;
  for (const char letter : name) {
    if (std::isupper(letter) != 0 && !result.empty()) result += '_';
    result += static_cast<char>(std::toupper(letter));
  }
  return result;
}

const pb::Descriptor& message(const std::string& name) {
  const pb::Descriptor* found =
      pb::DescriptorPool::generated_pool()->FindMessageTypeByName("hapticd.v1." + name);
  REQUIRE(found != nullptr);
  return *found;
}

TEST_CASE("every file is proto3 of package hapticd.v1") {
  for (const pb::FileDescriptor* file : file_descriptors()) {
    CAPTURE(file->name());
    CHECK(file->syntax() == pb::FileDescriptor::SYNTAX_PROTO3);
    CHECK(file->package() == "hapticd.v1");
  }
}

TEST_CASE(
    "every enum begins with UNSPECIFIED = 0, and its name leads all its values, each with a number "
    "of its own but for aliases") {
  for (const pb::EnumDescriptor* type : enum_descriptors()) {
    const std::string prefix = upper_snake(type->name()) + '_';
    CAPTURE(prefix);
    REQUIRE(type->value(0)->number() == 0);
    CHECK(type->value(0)->name() == prefix + "UNSPECIFIED");
    std::set<int> numbers;
    for (int i = 0; i < type->value_count(); ++i) {
      CAPTURE(type->value(i)->name());
      CHECK(type->value(i)->name().rfind(prefix, 0) == 0);
      const bool first = numbers.insert(type->value(i)->number()).second;
      CHECK((first || type->options().allow_alias()));
    }
  }
}

TEST_CASE("field numbers leave no gaps, so that a removed field must be reserved") {
  for (const pb::Descriptor* type : message_descriptors()) {
    int next = 1;
    for (const pb::FieldDescriptor* field : fields_of(*type)) {
      CAPTURE(field->full_name());
      while (type->IsReservedNumber(next)) ++next;
      CHECK(field->number() == next);
      ++next;
    }
  }
}

TEST_CASE("numbers 1000 to 1999 stay free for private experiments where messages grow") {
  for (const std::string name : {"Packet", "Item", "State", "Scene", "TickRecord"}) {
    CAPTURE(name);
    CHECK(message(name).IsReservedNumber(1000));
    CHECK(message(name).IsReservedNumber(1999));
  }
}

TEST_CASE("what is sent every tick has tags of one byte") {
  for (const std::string name : {"Packet", "ToolState", "ContactPatch", "StringState", "Tone",
                                 "Contact", "StringRadius", "PoseSample"}) {
    for (const pb::FieldDescriptor* field : fields_of(message(name))) {
      CAPTURE(field->full_name());
      CHECK(field->number() <= 15);
    }
  }
  for (const std::string name : {"tone", "contact", "string_radius", "pose_batch"}) {
    CHECK(message("Item").FindFieldByName(name)->number() <= 15);
  }
}

TEST_CASE("repeated numbers are packed") {
  for (const pb::Descriptor* type : message_descriptors()) {
    for (const pb::FieldDescriptor* field : fields_of(*type)) {
      CAPTURE(field->full_name());
      if (field->is_repeated() && is_number(*field)) CHECK(field->is_packed());
    }
  }
}

TEST_CASE("whatever a replay computes with is double and keeps its bits") {
  const std::set<std::string> kept{"hapticd.v1.Pose", "hapticd.v1.Twist", "hapticd.v1.Wrench"};
  for (const std::string& name : kept) {
    const auto* type = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(name);
    for (const pb::FieldDescriptor* field : fields_of(*type)) {
      CHECK(field->type() == pb::FieldDescriptor::TYPE_DOUBLE);
      CHECK(field->is_repeated());  // written even when it is 0 or -0
    }
  }
  for (const std::string name : {"ToolInput", "ToolOutput", "StateBlock", "PoseSample"}) {
    for (const pb::FieldDescriptor* field : fields_of(message(name))) {
      CAPTURE(field->full_name());
      CHECK(field->type() != pb::FieldDescriptor::TYPE_FLOAT);
      const bool monogram = field->name().rfind("pose_", 0) == 0 ||
                            field->name().rfind("twist_", 0) == 0 ||
                            field->name().rfind("wrench_", 0) == 0;
      if (monogram) CHECK(kept.count(field->message_type()->full_name()) == 1);
    }
  }
}

TEST_CASE("no message contains itself") {
  for (const pb::Descriptor* type : message_descriptors()) {
    std::set<const pb::Descriptor*> inside;
    std::set<const pb::Descriptor*> open{type};
    while (!open.empty()) {
      const pb::Descriptor* next = *open.begin();
      open.erase(open.begin());
      for (const pb::FieldDescriptor* field : fields_of(*next)) {
        if (field->message_type() != nullptr && inside.insert(field->message_type()).second) {
          open.insert(field->message_type());
        }
      }
    }
    CAPTURE(type->full_name());
    CHECK(inside.count(type) == 0);
  }
}

}  // namespace
}  // namespace hapticd::test
