// What counts of a device's damping once it was measured: in its profile, and by that where energy
// is repaid. Truth: what was kept, and the sheet it came to.
#include <cmath>

#include "device/attach/attach.h"
#include "device/attach/damping_record.h"
#include "tests/device/attach/check_folder.h"

namespace hapticd::test {
namespace {

constexpr double kMeasured = 0.4;

/// A device whose record says so of x and z, along which it pushes; y, which it lacks, says less.
struct MeasuredDevice {
  explicit MeasuredDevice(bool z_too = true) {
    subject.device = checked_device(pen("S1"), kStated, AxisMapping{});
    subject.can_push = {true, false, true};
    MeasuredDamping known;
    known[0] = DampingBounds{0.7, 0.9, 0.15};
    known[1] = DampingBounds{0.1, 0.2, 0.15};
    if (z_too) known[2] = DampingBounds{kMeasured, 1.2, 0.15};
    keep_damping(folder.path(), subject.device, known);
  }
  /// The damping of a profile that states `stated`, once it was counted.
  [[nodiscard]] DeviceSheet counted(double stated, bool guess) const {
    DeviceSheet sheet;
    state_number(sheet, &DeviceProfile::damping, {stated}, {0, "a test", guess});
    count_damping(DeviceCheck(subject, folder.path()), sheet);
    return sheet;
  }

  CheckFolder folder;
  CheckSubject subject;
};

}  // namespace

TEST_CASE("a guess counts as what was measured at least, and is no guess any more") {
  const MeasuredDevice device;
  for (const double guess : {0.1, 0.5, 8.0}) {
    const DeviceSheet sheet = device.counted(guess, true);
    CHECK(sheet.profile.damping == kMeasured);
    CHECK_FALSE(sheet.profile.damping_guessed);
    CHECK(source_of(sheet, &DeviceProfile::damping).text.find("measured") == 0);
  }
  DeviceSheet open;
  REQUIRE(open.profile.damping_guessed);
  count_damping(DeviceCheck(device.subject, device.folder.path()), open);
  CHECK(open.profile.damping == kMeasured);
  CHECK_FALSE(open.profile.damping_guessed);
}

TEST_CASE("a statement holds unless it is more than was found at most along any axis") {
  const MeasuredDevice device;
  CHECK(device.counted(0.2, false).profile.damping == 0.2);
  CHECK(device.counted(0.9, false).profile.damping == 0.9);
  CHECK(device.counted(std::nextafter(0.9, 1.0), false).profile.damping == kMeasured);
}

TEST_CASE("while an axis is not measured, or the record is not this device's, a guess stays one") {
  const MeasuredDevice half(false);
  CHECK(half.counted(0.5, true).profile.damping == 0.5);
  CHECK(half.counted(0.5, true).profile.damping_guessed);
  MeasuredDevice other;
  other.subject.device = checked_device(pen("S2"), kStated, AxisMapping{});
  CHECK(other.counted(0.5, true).profile.damping == 0.5);
  CHECK(other.counted(0.5, true).profile.damping_guessed);
}

}  // namespace hapticd::test
