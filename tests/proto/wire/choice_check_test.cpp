// Enum numbers that no value has, put into every field of every request by reflection.
#include "proto/wire/choice_check.h"

#include <doctest/doctest.h>

#include <functional>
#include <limits>

#include "hapticd/v1/config.pb.h"
#include "hapticd/v1/stream.pb.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

/// Calls `at` once for each enum field in and below `message`, with that field set to `number`, and
/// the field's path. Repeated fields have two elements then, of which the second is told.
// NOLINTNEXTLINE(misc-no-recursion): as deep as the schema
void for_each_choice(pb::Message& root, pb::Message& message, int number, const std::string& path,
                     const std::function<void(const std::string&)>& at) {
  const pb::Reflection& r = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.GetDescriptor()->field(i);
    const std::string here = path.empty() ? field.name() : path + "." + field.name();
    if (field.type() == pb::FieldDescriptor::TYPE_ENUM) {
      if (field.is_repeated()) {
        r.AddEnumValue(&message, &field, 1);
        r.AddEnumValue(&message, &field, number);
      } else {
        r.SetEnumValue(&message, &field, number);
      }
      at(field.is_repeated() ? here + "[1]" : here);
      r.ClearField(&message, &field);
    } else if (field.type() == pb::FieldDescriptor::TYPE_MESSAGE) {
      pb::Message* below = nullptr;
      if (field.is_repeated()) r.AddMessage(&message, &field);
      below =
          field.is_repeated() ? r.AddMessage(&message, &field) : r.MutableMessage(&message, &field);
      for_each_choice(root, *below, number, field.is_repeated() ? here + "[1]" : here, at);
      r.ClearField(&message, &field);
    }
  }
}

/// How many fields were found unknown, each by its own path.
int count_unknown(pb::Message& root, int number) {
  int count = 0;
  for_each_choice(root, root, number, "", [&](const std::string& path) {
    const auto unknown = wire::unknown_choice(root);
    REQUIRE(unknown.has_value());
    CHECK(unknown->path == path);
    CHECK(unknown->message.find(std::to_string(number) + " is not a value of ") == 0);
    ++count;
  });
  return count;
}

constexpr int kUnknown[] = {9999, 77, -1, std::numeric_limits<int>::max(),
                            std::numeric_limits<int>::min()};

}  // namespace

TEST_CASE("a number that no enum has is found in every field of every Item, by its path") {
  for (const int number : kUnknown) {
    v1::Item item;
    CHECK(count_unknown(item, number) > 20);
  }
}

TEST_CASE("a number that no enum has is found in every field of a configuration") {
  for (const int number : kUnknown) {
    v1::Config config;
    CHECK(count_unknown(config, number) == 4);
  }
}

TEST_CASE("the numbers that an enum has, and none at all, are known") {
  v1::Item item;
  CHECK_FALSE(wire::unknown_choice(item).has_value());
  for (int number = 0; number <= 4; ++number) {
    item.mutable_play_gesture()->set_arm(static_cast<v1::Arm>(number));
    CHECK_FALSE(wire::unknown_choice(item).has_value());
  }
  item.mutable_play_gesture()->set_arm(static_cast<v1::Arm>(5));
  REQUIRE(wire::unknown_choice(item).has_value());
  CHECK(wire::unknown_choice(item)->message ==
        "5 is not a value of Arm. Choose ARM_OFF, ARM_LIGHT, ARM_FIRM, ARM_ADVERSARIAL.");
}

}  // namespace hapticd::test
