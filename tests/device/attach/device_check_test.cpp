// The guided check as a person goes through it. Truth: the directions of a device with so many
// axes, counted by hand.
#include "device/attach/device_check.h"

#include <algorithm>

#include "tests/device/attach/check_folder.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// +x -x +y -y +z -z.
const std::vector<PushAxis> kAll{1, 2, 3, 4, 5, 6};

CheckSubject subject(std::array<bool, 3> can_push = {true, true, true},
                     const std::string& serial = "S1") {
  CheckSubject made;
  made.profile.axes.force_sign = {1.0, -1.0, 1.0};
  made.device = checked_device(pen(serial), kStated, made.profile.axes);
  made.profile.name = "pen";
  made.can_push = can_push;
  return made;
}

/// Pushed along one direction, felt along another.
CheckAnswer feel(DeviceCheck& check, PushAxis pushed, PushAxis felt) {
  check.note_push(pushed, kSecond_ns);
  return check.confirm(felt);
}

CheckAnswer pass(DeviceCheck& check) {
  CheckAnswer last;
  for (const PushAxis axis : kAll) {
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
    const CheckAnswer result = feel(check, kAll[k], kAll[k]);
    CHECK(result.verdict == CheckVerdict::kRight);
    const bool last = k + 1 == kAll.size();
    CHECK((result.words.find("next start of hapticd") != std::string::npos) == last);
  }
  CHECK(check.passed());
  CHECK(DeviceCheck(subject(), folder.path()).passed());
}

TEST_CASE("a direction confirmed twice is one, and a device of two axes has four") {
  const CheckFolder folder;
  DeviceCheck check(subject({true, true, false}), folder.path());
  CHECK_FALSE(check.has(kAll[4]));
  CHECK_FALSE(check.has(0));
  CHECK_FALSE(check.has(7));
  for (int k = 0; k < 4; ++k) CHECK(feel(check, kAll[0], kAll[0]).verdict == CheckVerdict::kRight);
  CHECK(check.confirmed().size() == 1);
  CHECK_FALSE(check.passed());
  CHECK(pass(check).verdict == CheckVerdict::kRight);
  CHECK(check.confirmed().size() == 4);
  CHECK(check.passed());
}

TEST_CASE("a push is confirmed once, and not at all when it was cut short") {
  const CheckFolder folder;
  DeviceCheck check(subject(), folder.path());
  CHECK(check.confirm(kAll[0]).verdict == CheckVerdict::kNoPush);
  CHECK(feel(check, kAll[0], kAll[0]).verdict == CheckVerdict::kRight);
  CHECK(check.confirm(kAll[0]).verdict == CheckVerdict::kNoPush);
  check.note_push(kAll[1], 5 * kSecond_ns);
  check.note_no_force(5 * kSecond_ns);  // the snapshot of before the push
  check.note_no_force(6 * kSecond_ns);
  CHECK(check.confirm(kAll[1]).verdict == CheckVerdict::kRight);
  check.note_push(kAll[2], 7 * kSecond_ns);
  check.note_no_force(8 * kSecond_ns - 1);
  CHECK(check.confirm(kAll[2]).verdict == CheckVerdict::kNoPush);
  CHECK(check.confirmed().size() == 2);
}

TEST_CASE("felt the other way round it begins anew and names the line of the profile") {
  const CheckFolder folder;
  DeviceCheck check(subject(), folder.path());
  CHECK(feel(check, kAll[0], kAll[0]).verdict == CheckVerdict::kRight);
  CheckAnswer result = feel(check, kAll[4], kAll[5]);
  CHECK(result.verdict == CheckVerdict::kFeltWrong);
  CHECK(result.words.find("profile pen") != std::string::npos);
  CHECK(result.words.find("force_sign { value: [1, -1, -1]") != std::string::npos);
  CHECK(check.confirmed().empty());
  // What is -1 already becomes 1 again.
  result = feel(check, kAll[3], kAll[2]);
  CHECK(result.words.find("force_sign { value: [1, 1, 1]") != std::string::npos);
  result = feel(check, kAll[0], kAll[2]);
  CHECK(result.verdict == CheckVerdict::kFeltWrong);
  CHECK(result.words.find("axis_map { axes") != std::string::npos);
  CHECK(result.words.size() <= 400);
}

TEST_CASE("a checked device that is felt to push wrongly is none any more") {
  const CheckFolder folder;
  {
    DeviceCheck check(subject(), folder.path());
    pass(check);
  }
  DeviceCheck check(subject(), folder.path());
  REQUIRE(check.passed());
  CHECK(feel(check, kAll[0], kAll[1]).verdict == CheckVerdict::kFeltWrong);
  CHECK_FALSE(check.passed());
  CHECK_FALSE(DeviceCheck(subject(), folder.path()).passed());
}

TEST_CASE("a device without a serial cannot be remembered, and is told so") {
  const CheckFolder folder;
  DeviceCheck check(subject({true, true, true}, ""), folder.path());
  const CheckAnswer result = pass(check);
  CHECK(result.verdict == CheckVerdict::kNotKept);
  CHECK(result.words.find("no serial number") != std::string::npos);
  CHECK_FALSE(check.passed());
  CHECK_FALSE(DeviceCheck(subject({true, true, true}, ""), folder.path()).passed());
}

TEST_CASE("where nothing can be kept the last confirmation fails, and may be tried again") {
  const CheckFolder folder;
  std::filesystem::create_directories(folder.path().parent_path());
  set_text(folder.path(), "no folder");
  DeviceCheck check(subject(), folder.path());
  CHECK(pass(check).verdict == CheckVerdict::kNotKept);
  CHECK_FALSE(check.passed());
  std::filesystem::remove(folder.path());
  CHECK(feel(check, kAll[0], kAll[0]).verdict == CheckVerdict::kRight);
  CHECK(check.passed());
}

TEST_CASE("the axes that can push are named in the base frame, whichever the device's own are") {
  AxisMapping axes;
  axes.raw_axis = {2, 0, 1};
  // The device pushes along its own first two axes: they are y and z of D.
  CHECK(pushing_axes({true, true, false}, axes) == std::array<bool, 3>{false, true, true});
}

}  // namespace hapticd::test
