// Five fingers, two hands: nothing that belongs to a tool may assume that there is one. Everything
// that has a pose, wrench, twist or contact of a tool, or a device, carries a tool_id, and whoever
// holds such things holds any number of them.
#include <doctest/doctest.h>

#include <regex>
#include <set>
#include <string>

#include "tests/protocol/schema.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

bool carries_tool_id(const pb::Descriptor& message) {
  const pb::FieldDescriptor* field = message.FindFieldByName("tool_id");
  return field != nullptr && field->type() == pb::FieldDescriptor::TYPE_UINT32;
}

/// Monogram names in which H (haptic tool), G (graphic tool) or C (contact) occurs as a frame or
/// point of the pose, twist, wrench or normal.
bool belongs_to_a_tool(const std::string& field_name) {
  static const std::regex monogram(
      "(pose|p|q)_[wd][hgc](_.*)?|(pose|p|q)_g[a-z](_.*)?|twist_[a-z]*h[a-z]*_.*|"
      "wrench_(unlimited_)?h_.*|nhat_og_.*");
  return std::regex_match(field_name, monogram);
}

/// True when `message` carries a tool_id, or occurs only inside messages that do.
// NOLINTNEXTLINE(misc-no-recursion): messages nest a few levels deep and never contain themselves
bool is_inside_a_tool(const pb::Descriptor& message) {
  if (carries_tool_id(message)) return true;
  bool held = false;
  for (const pb::Descriptor* holder : message_descriptors()) {
    for (const pb::FieldDescriptor* field : fields_of(*holder)) {
      if (field->message_type() != &message) continue;
      held = true;
      if (!is_inside_a_tool(*holder)) return false;
    }
  }
  return held;
}

TEST_CASE("poses, twists, wrenches and contacts of tools carry a tool_id") {
  int seen = 0;
  for (const pb::Descriptor* message : message_descriptors()) {
    for (const pb::FieldDescriptor* field : fields_of(*message)) {
      if (!belongs_to_a_tool(field->name())) continue;
      CAPTURE(field->full_name());
      CHECK(is_inside_a_tool(*message));
      ++seen;
    }
  }
  CHECK(seen >= 20);
}

TEST_CASE("messages about a tool, contact or device carry a tool_id") {
  for (const std::string name :
       {"Tool",        "ToolState",      "ToolInput",    "ToolOutput",     "ToolEnergy",
        "DeviceState", "DeviceInfo",     "DeviceChoice", "RecordedDevice", "ContactPatch",
        "Contact",     "Tone",           "PoseSample",   "Calibrate",      "Recentre",
        "Clutch",      "StiffnessState", "GestureState", "GestureTrack",   "Fault",
        "StateBlock"}) {
    CAPTURE(name);
    const auto* message =
        pb::DescriptorPool::generated_pool()->FindMessageTypeByName("hapticd.v1." + name);
    REQUIRE(message != nullptr);
    CHECK(carries_tool_id(*message));
  }
}

TEST_CASE("whoever holds what has a tool_id can hold any number of it") {
  for (const pb::Descriptor* message : message_descriptors()) {
    for (const pb::FieldDescriptor* field : fields_of(*message)) {
      if (field->message_type() == nullptr || !carries_tool_id(*field->message_type())) continue;
      CAPTURE(field->full_name());
      const bool one_item_among_many = message->full_name() == "hapticd.v1.Item";
      // A string sounds in one way, whoever has touched it last; strings repeat.
      const bool of_a_string = field->full_name() == "hapticd.v1.StringState.sounding";
      CHECK((field->is_repeated() || one_item_among_many || of_a_string));
    }
  }
}

TEST_CASE("fields called tools, devices, contacts, poses, inputs and outputs repeat") {
  const std::set<std::string> plural{"tools",  "devices", "device", "contacts", "poses",
                                     "inputs", "outputs", "parts",  "tracks",   "stiffness"};
  const std::set<std::string> lists{"hapticd.v1.DeviceInfoList"};
  for (const pb::Descriptor* message : message_descriptors()) {
    for (const pb::FieldDescriptor* field : fields_of(*message)) {
      if (plural.count(field->name()) == 0) continue;
      CAPTURE(field->full_name());
      const bool is_list =
          field->message_type() != nullptr && lists.count(field->message_type()->full_name()) == 1;
      CHECK((field->is_repeated() || is_list));
    }
  }
}

}  // namespace
}  // namespace hapticd::test
