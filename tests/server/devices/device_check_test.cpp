// The guided check as a person goes through it. Truth: the directions of a device with so many
// axes, counted by hand.
#include "server/devices/device_check.h"

#include <algorithm>

#include "tests/server/devices/check_folder.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

const std::vector<v1::Axis> kAll{v1::AXIS_POSITIVE_X, v1::AXIS_NEGATIVE_X, v1::AXIS_POSITIVE_Y,
                                 v1::AXIS_NEGATIVE_Y, v1::AXIS_POSITIVE_Z, v1::AXIS_NEGATIVE_Z};

CheckSubject subject(std::array<bool, 3> can_push = {true, true, true},
                     const std::string& serial = "S1") {
  CheckSubject made;
  made.axes.force_sign = {1.0, -1.0, 1.0};
  made.device = checked_device(pen(serial), kStated, made.axes);
  made.profile = "pen";
  made.can_push = can_push;
  return made;
}

/// Pushed along one direction, felt along another.
v1::Result feel(DeviceCheck& check, v1::Axis pushed, v1::Axis felt) {
  check.note_push(pushed, kSecond_ns);
  return check.confirm(felt);
}

v1::Result pass(DeviceCheck& check) {
  v1::Result last;
  for (const v1::Axis axis : kAll) {
    if (check.has(axis)) last = feel(check, axis, axis);
  }
  return last;
}

}  // namespace

TEST_CASE("a device is checked once all six directions are confirmed, and stays so") {
  const CheckFolder folder;
  DeviceCheck check(subject(), folder.path());
  for (std::size_t k = 0; k < kAll.size(); ++k) {
    CHECK_FALSE(check.passed());
    CHECK(check.confirmed().size() == k);
    const v1::Result result = feel(check, kAll[k], kAll[k]);
    CHECK(result.code() == v1::RESULT_CODE_OK);
    const bool last = k + 1 == kAll.size();
    CHECK((result.message().find("next start of hapticd") != std::string::npos) == last);
  }
  CHECK(check.passed());
  CHECK(DeviceCheck(subject(), folder.path()).passed());
}

TEST_CASE("a direction confirmed twice is one, and a device of two axes has four") {
  const CheckFolder folder;
  DeviceCheck check(subject({true, true, false}), folder.path());
  CHECK_FALSE(check.has(v1::AXIS_POSITIVE_Z));
  CHECK_FALSE(check.has(v1::AXIS_UNSPECIFIED));
  CHECK_FALSE(check.has(static_cast<v1::Axis>(7)));
  for (int k = 0; k < 4; ++k) CHECK(feel(check, kAll[0], kAll[0]).code() == v1::RESULT_CODE_OK);
  CHECK(check.confirmed().size() == 1);
  CHECK_FALSE(check.passed());
  CHECK(pass(check).code() == v1::RESULT_CODE_OK);
  CHECK(check.confirmed().size() == 4);
  CHECK(check.passed());
}

TEST_CASE("a push is confirmed once, and not at all when it was cut short") {
  const CheckFolder folder;
  DeviceCheck check(subject(), folder.path());
  CHECK(check.confirm(kAll[0]).code() == v1::RESULT_CODE_WRONG_STATE);
  CHECK(feel(check, kAll[0], kAll[0]).code() == v1::RESULT_CODE_OK);
  CHECK(check.confirm(kAll[0]).code() == v1::RESULT_CODE_WRONG_STATE);
  check.note_push(kAll[1], 5 * kSecond_ns);
  check.note_no_force(5 * kSecond_ns);  // the snapshot of before the push
  check.note_no_force(6 * kSecond_ns);
  CHECK(check.confirm(kAll[1]).code() == v1::RESULT_CODE_OK);
  check.note_push(kAll[2], 7 * kSecond_ns);
  check.note_no_force(8 * kSecond_ns - 1);
  CHECK(check.confirm(kAll[2]).code() == v1::RESULT_CODE_WRONG_STATE);
  CHECK(check.confirmed().size() == 2);
}

TEST_CASE("felt the other way round it begins anew and names the line of the profile") {
  const CheckFolder folder;
  DeviceCheck check(subject(), folder.path());
  CHECK(feel(check, kAll[0], kAll[0]).code() == v1::RESULT_CODE_OK);
  v1::Result result = feel(check, v1::AXIS_POSITIVE_Z, v1::AXIS_NEGATIVE_Z);
  CHECK(result.code() == v1::RESULT_CODE_INVALID);
  CHECK(result.message().find("profile pen") != std::string::npos);
  CHECK(result.message().find("force_sign { value: [1, -1, -1]") != std::string::npos);
  CHECK(check.confirmed().empty());
  // What is -1 already becomes 1 again.
  result = feel(check, v1::AXIS_NEGATIVE_Y, v1::AXIS_POSITIVE_Y);
  CHECK(result.message().find("force_sign { value: [1, 1, 1]") != std::string::npos);
  result = feel(check, v1::AXIS_POSITIVE_X, v1::AXIS_POSITIVE_Y);
  CHECK(result.code() == v1::RESULT_CODE_INVALID);
  CHECK(result.message().find("axis_map { axes") != std::string::npos);
  CHECK(result.message().size() <= 400);
}

TEST_CASE("a checked device that is felt to push wrongly is none any more") {
  const CheckFolder folder;
  {
    DeviceCheck check(subject(), folder.path());
    pass(check);
  }
  DeviceCheck check(subject(), folder.path());
  REQUIRE(check.passed());
  CHECK(feel(check, kAll[0], kAll[1]).code() == v1::RESULT_CODE_INVALID);
  CHECK_FALSE(check.passed());
  CHECK_FALSE(DeviceCheck(subject(), folder.path()).passed());
}

TEST_CASE("a device without a serial cannot be remembered, and is told so") {
  const CheckFolder folder;
  DeviceCheck check(subject({true, true, true}, ""), folder.path());
  const v1::Result result = pass(check);
  CHECK(result.code() == v1::RESULT_CODE_FAILED);
  CHECK(result.message().find("no serial number") != std::string::npos);
  CHECK_FALSE(check.passed());
  CHECK_FALSE(DeviceCheck(subject({true, true, true}, ""), folder.path()).passed());
}

TEST_CASE("where nothing can be kept the last confirmation fails, and may be tried again") {
  const CheckFolder folder;
  std::filesystem::create_directories(folder.path().parent_path());
  set_text(folder.path(), "no folder");
  DeviceCheck check(subject(), folder.path());
  CHECK(pass(check).code() == v1::RESULT_CODE_FAILED);
  CHECK_FALSE(check.passed());
  std::filesystem::remove(folder.path());
  CHECK(feel(check, kAll[0], kAll[0]).code() == v1::RESULT_CODE_OK);
  CHECK(check.passed());
}

TEST_CASE("the axes that can push are named in the base frame, whichever the device's own are") {
  AxisMapping axes;
  axes.raw_axis = {2, 0, 1};
  // The device pushes along its own first two axes: they are y and z of D.
  CHECK(pushing_axes({true, true, false}, axes) == std::array<bool, 3>{false, true, true});
}

}  // namespace hapticd::test
