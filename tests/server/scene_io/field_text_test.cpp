// Every text of a scene is UTF-8, or the scene is refused: no Packet can hold it. Judged by
// protobuf's own rule for strings.
#include <doctest/doctest.h>
#include <google/protobuf/message.h>
#include <google/protobuf/stubs/common.h>

#include <functional>

#include "tests/server/scene_io/full_scene.h"
#include "tests/server/scene_io/inline_text.h"

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

bool is_text(const std::string& bytes) { return pb::internal::IsStructurallyValidUTF8(bytes); }

/// A text of a message, or where one could be.
struct TextField {
  std::string path;
  const pb::FieldDescriptor& field;
  pb::Message& owner;
};

/// Calls visit for every text of `message` and below.
// NOLINTNEXTLINE(misc-no-recursion): a schema is a tree
void for_each_text(pb::Message& message, const std::string& path,
                   const std::function<void(const TextField&)>& visit) {
  const pb::Reflection& r = *message.GetReflection();
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const std::string here = path.empty() ? field.name() : path + "." + field.name();
    if (field.type() == pb::FieldDescriptor::TYPE_STRING) visit({here, field, message});
    if (field.message_type() == nullptr) continue;
    if (field.is_repeated()) {
      for (int k = 0; k < r.FieldSize(message, &field); ++k) {
        for_each_text(*r.MutableRepeatedMessage(&message, &field, k),
                      here + "[" + std::to_string(k) + "]", visit);
      }
    } else if (r.HasField(message, &field)) {
      for_each_text(*r.MutableMessage(&message, &field), here, visit);
    }
  }
}

}  // namespace

TEST_CASE("no text of a scene is taken that is no UTF-8, and the refusal itself is") {
  for (const std::string& bad : {std::string("a\377b"), std::string("\xc3"), std::string("\x80"),
                                 std::string("x\xed\xa0\x80"), std::string("\xc0\xaf")}) {
    int texts = 0;
    v1::Scene whole = full_scene();
    for_each_text(whole, "", [&](const TextField& text) {
      v1::Scene scene = full_scene();
      // The same place in a scene that nothing else depends on.
      for_each_text(scene, "", [&](const TextField& same) {
        if (same.path != text.path) return;
        const pb::Reflection& r = *same.owner.GetReflection();
        if (!same.field.is_repeated()) {
          r.SetString(&same.owner, &same.field, bad);
        } else if (r.FieldSize(same.owner, &same.field) > 0) {
          r.SetRepeatedString(&same.owner, &same.field, 0, bad);
        } else {
          r.AddString(&same.owner, &same.field, bad);
        }
      });
      const LoadResult result = load_inline(print_scene(scene));
      CAPTURE(text.path);
      CHECK(result.loaded == nullptr);
      const std::string path = text.field.is_repeated() ? text.path + "[0]" : text.path;
      const SceneProblem* fault = find_fault(result.problems, path);
      REQUIRE(fault != nullptr);
      CHECK(fault->message == "is not UTF-8 text");
      CHECK(fault->line > 0);
      CHECK_FALSE(fault->remedy.empty());
      CHECK(is_text(list(result.problems)));
      ++texts;
    });
    CHECK(texts > 10);
  }
}

TEST_CASE("no text of a gesture or a profile is taken that is no UTF-8") {
  for (const char* field : {"name", "description"}) {
    const std::string text = std::string(field) +
                             ": \"a\\377b\" tracks { waypoints { pose_wh {} } waypoints { pose_wh "
                             "{} duration_s: 1 } }";
    const GestureResult result = load_gesture_text(text);
    CHECK_FALSE(result.gesture);
    const SceneProblem* fault = find_fault(result.problems, field);
    REQUIRE(fault != nullptr);
    CHECK(fault->message == "is not UTF-8 text");
    CHECK(is_text(list(result.problems)));
  }
  const ProfileResult profile = load_profile_text(
      "name: \"p\" driver: DRIVER_HID peak_force_n { value: 5 source: \"\\377\" } peak_torque_n_m "
      "{ value: 1 source: \"s\" }");
  CHECK_FALSE(profile.loaded);
  const SceneProblem* fault = find_fault(profile.problems, "peak_force_n.source");
  REQUIRE(fault != nullptr);
  CHECK(fault->message == "is not UTF-8 text");
}

}  // namespace hapticd::test
