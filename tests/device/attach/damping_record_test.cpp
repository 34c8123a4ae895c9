// What was measured of a device's damping, as it is kept. Truth: what was put in.
#include "device/attach/damping_record.h"

#include <filesystem>
#include <stdexcept>

#include "tests/device/attach/check_folder.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

CheckedDevice device(const std::string& serial = "S1") {
  return checked_device(pen(serial), kStated, AxisMapping{});
}

MeasuredDamping measured() {
  MeasuredDamping all;
  all[0] = DampingBounds{0.1 + 0.2, 0.75, 0.15};
  all[2] = DampingBounds{1.25e-2, 2.0, 1.0 / 3.0};
  return all;
}

bool same(const MeasuredDamping& a, const MeasuredDamping& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].has_value() != b[i].has_value()) return false;
    if (a[i] &&
        (a[i]->lower != b[i]->lower || a[i]->upper != b[i]->upper || a[i]->mass != b[i]->mass)) {
      return false;
    }
  }
  return true;
}

}  // namespace

TEST_CASE("what was measured is kept to the last bit, for its device alone") {
  const CheckFolder folder;
  CHECK(same(read_damping(folder.path(), device()), {}));
  keep_damping(folder.path(), device(), measured());
  CHECK(same(read_damping(folder.path(), device()), measured()));
  CHECK(same(read_damping(folder.path(), device("S2")), {}));
  CHECK(same(read_damping(folder.path(), device("")), {}));
  AxisMapping other;
  other.force_scale = {2.0, 1.0, 1.0};
  CHECK(same(read_damping(folder.path(), checked_device(pen("S1"), kStated, other)), {}));
}

TEST_CASE("a file that anything has changed does not count, and stays as it is") {
  const CheckFolder folder;
  keep_damping(folder.path(), device(), measured());
  const fs::path file = damping_file(folder.path(), device());
  const std::string good = text_of(file);
  SplitMix64 random(fresh_seed());
  for (std::size_t place = 0; place < good.size(); ++place) {
    std::string bad = good;
    bad[place] = static_cast<char>(bad[place] ^ static_cast<char>(1 + random.below(255)));
    set_text(file, bad);
    CAPTURE(bad);
    CHECK(same(read_damping(folder.path(), device()), {}));
    CHECK(text_of(file) == bad);
  }
  for (const std::string& bad : {good.substr(0, good.size() - 1), good + "x", std::string()}) {
    set_text(file, bad);
    CHECK(same(read_damping(folder.path(), device()), {}));
  }
  fs::remove(file);
  fs::create_directory(file);
  CHECK(same(read_damping(folder.path(), device()), {}));
}

TEST_CASE("what cannot be written is said with the remedy, and what was there stays") {
  const CheckFolder folder;
  keep_damping(folder.path(), device(), measured());
  fs::create_directory(damping_file(folder.path(), device()).string() + ".new");
  CHECK_THROWS_AS(keep_damping(folder.path(), device(), {}), std::runtime_error);
  CHECK(same(read_damping(folder.path(), device()), measured()));
}

TEST_CASE("damping counts once each axis that pushes was measured, and then the lowest") {
  MeasuredDamping all = measured();
  CHECK_FALSE(counted_damping(all, {true, true, true}));
  CHECK(counted_damping(all, {true, false, true})->lower == 1.25e-2);
  CHECK(counted_damping(all, {true, false, false})->lower == 0.1 + 0.2);
  all[1] = DampingBounds{1e-3, 5.0, 0.2};
  CHECK(counted_damping(all, {true, true, true})->lower == 1e-3);
  CHECK(counted_damping(all, {true, true, true})->upper == 0.75);
  CHECK_FALSE(counted_damping(all, {false, false, false}));
}

TEST_CASE(
    "a check keeps what was found, knows it again, and says what to do where it was nothing") {
  const CheckFolder folder;
  CheckSubject subject;
  subject.device = device();
  subject.can_push = {true, false, true};
  DeviceCheck check(subject, folder.path());
  const CheckAnswer held = check.note_damping(1, {RingVerdict::kHeld, {}});
  CHECK(held.verdict == CheckVerdict::kNotMeasured);
  CHECK(held.words.find("hands off") != std::string::npos);
  CHECK_FALSE(fs::exists(damping_file(folder.path(), subject.device)));
  const CheckAnswer first = check.note_damping(1, {RingVerdict::kMeasured, *measured()[0]});
  CHECK(first.verdict == CheckVerdict::kRight);
  CHECK(first.words.find("still to be measured") != std::string::npos);
  const CheckAnswer last = check.note_damping(6, {RingVerdict::kMeasured, *measured()[2]});
  CHECK(last.words.find("next start") != std::string::npos);
  CHECK(same(DeviceCheck(subject, folder.path()).damping(), measured()));
  // Full force is another matter.
  CHECK_FALSE(check.passed());
}

TEST_CASE("a device without a serial number cannot be known again, so nothing is said to be kept") {
  const CheckFolder folder;
  CheckSubject subject;
  subject.device = device("");
  subject.can_push = {true, false, false};
  DeviceCheck check(subject, folder.path());
  const CheckAnswer answer = check.note_damping(1, {RingVerdict::kMeasured, *measured()[0]});
  CHECK(answer.verdict == CheckVerdict::kNotKept);
}

}  // namespace hapticd::test
