// Records of passed checks: kept, and of no worth as soon as anything is another. Truth: what was
// written and changed.
#include "device/attach/check_record.h"

#include <functional>

#include "tests/device/attach/check_folder.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

CheckedDevice checked_pen() { return checked_device(pen(), kStated, {}); }

}  // namespace

TEST_CASE("a passed check is remembered by the next one that looks, and by nobody before") {
  const CheckFolder folder;
  CHECK_FALSE(is_remembered(folder.path(), checked_pen()));
  remember_check(folder.path(), checked_pen());
  CHECK(is_remembered(folder.path(), checked_pen()));
  remember_check(folder.path(), checked_pen());
  CHECK(is_remembered(folder.path(), checked_pen()));
  // Nothing half-written stays behind.
  CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
  forget_check(folder.path(), checked_pen());
  CHECK_FALSE(is_remembered(folder.path(), checked_pen()));
  CHECK_NOTHROW(forget_check(folder.path(), checked_pen()));
}

TEST_CASE("another firmware, number of the USB, axis or sign is another device") {
  const CheckFolder folder;
  remember_check(folder.path(), checked_pen());
  const auto remembered = [&](const std::function<void(HidrawNode&, AxisMapping&)>& change) {
    HidrawNode node = pen();
    AxisMapping axes;
    change(node, axes);
    return is_remembered(folder.path(), checked_device(node, kStated, axes));
  };
  REQUIRE(remembered([](HidrawNode&, AxisMapping&) {}));
  CHECK(remembered([](HidrawNode& node, AxisMapping&) { node.path = "/dev/hidraw0"; }));
  CHECK_FALSE(remembered([](HidrawNode& node, AxisMapping&) { node.serial = "S2"; }));
  CHECK_FALSE(remembered([](HidrawNode& node, AxisMapping&) { node.product += "2"; }));
  CHECK_FALSE(remembered([](HidrawNode& node, AxisMapping&) { node.vendor_id = 2; }));
  CHECK_FALSE(remembered([](HidrawNode& node, AxisMapping&) { node.product_id = 2; }));
  CHECK_FALSE(remembered([](HidrawNode&, AxisMapping& axes) { axes.raw_axis = {1, 0, 2}; }));
  CHECK_FALSE(remembered([](HidrawNode&, AxisMapping& axes) { axes.sign[1] = -1.0; }));
  CHECK_FALSE(remembered([](HidrawNode&, AxisMapping& axes) { axes.force_sign[2] = -1.0; }));
  CHECK_FALSE(remembered([](HidrawNode&, AxisMapping& axes) { axes.force_scale[0] = 0.5; }));
  std::vector<std::uint8_t> other = kStated;
  for (std::uint8_t& byte : other) {
    byte ^= 1U;
    CHECK_FALSE(is_remembered(folder.path(), checked_device(pen(), other, {})));
    byte ^= 1U;
  }
  CHECK(is_remembered(folder.path(), checked_device(pen(), other, {})));
}

TEST_CASE("a file with any bit turned over, cut short or lengthened counts for nothing") {
  const CheckFolder folder;
  remember_check(folder.path(), checked_pen());
  const fs::path file = check_file(folder.path(), checked_pen());
  const std::string good = text_of(file);
  REQUIRE(good.size() > 64);
  const auto counts = [&](const std::string& text) {
    set_text(file, text);
    return is_remembered(folder.path(), checked_pen());
  };
  REQUIRE(counts(good));
  for (std::size_t k = 0; k < good.size(); ++k) {
    std::string damaged = good;
    damaged[k] = static_cast<char>(damaged[k] ^ (1 << (k % 8)));
    CHECK_FALSE(counts(damaged));
  }
  CHECK_FALSE(counts(""));
  CHECK_FALSE(counts(good.substr(0, good.size() - 1)));
  CHECK_FALSE(counts(good + "\n"));
  CHECK_FALSE(counts(good + std::string(10'000, ' ')));
  fs::remove(file);
  fs::create_directory(file);
  CHECK_FALSE(is_remembered(folder.path(), checked_pen()));
}

TEST_CASE("the record of one device under the name of another counts for nothing") {
  const CheckFolder folder;
  const CheckedDevice other = checked_device(pen("S2"), kStated, {});
  remember_check(folder.path(), checked_pen());
  fs::copy_file(check_file(folder.path(), checked_pen()), check_file(folder.path(), other));
  CHECK_FALSE(is_remembered(folder.path(), other));
}

TEST_CASE("serials that look alike in a file's name have files of their own, inside the folder") {
  const CheckFolder folder;
  const std::string longest(126, 'x');
  for (const std::string serial :
       {"a/b", "a_b", "../x", ".", "..", " ", "a\"b\n", longest.c_str()}) {
    CAPTURE(serial);
    const CheckedDevice device = checked_device(pen(serial), kStated, {});
    CHECK_FALSE(is_remembered(folder.path(), device));
    remember_check(folder.path(), device);
    CHECK(is_remembered(folder.path(), device));
    CHECK(check_file(folder.path(), device).parent_path() == folder.path());
  }
}

TEST_CASE("a folder that cannot be written is named with what to do, and nothing is remembered") {
  const CheckFolder folder;
  fs::create_directories(folder.path().parent_path());
  set_text(folder.path(), "a file where the folder should be");
  CHECK_THROWS_WITH_AS(remember_check(folder.path(), checked_pen()),
                       doctest::Contains("Give hapticd a folder it may write to"),
                       std::runtime_error);
  CHECK_FALSE(is_remembered(folder.path(), checked_pen()));
}

TEST_CASE("what was begun to be written and not ended does not count") {
  const CheckFolder folder;
  remember_check(folder.path(), checked_pen());
  const fs::path file = check_file(folder.path(), checked_pen());
  fs::rename(file, file.string() + ".new");
  CHECK_FALSE(is_remembered(folder.path(), checked_pen()));
}

}  // namespace hapticd::test
