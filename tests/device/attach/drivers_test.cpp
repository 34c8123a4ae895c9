// Which driver a source or a plugged-in device is for, and what it makes. Truth: the sources and
// descriptors put in.
#include "device/attach/drivers.h"

#include <doctest/doctest.h>

#include <set>
#include <string_view>

#include "device/attach/attach.h"
#include "device/hid/report_descriptor.h"
#include "device/pid/pid_driver.h"
#include "tests/device/pid/force_device.h"

namespace hapticd::test {

TEST_CASE("a source names a kind of device, and after a colon the serial or the file of one") {
  const auto parsed = [](const char* source) {
    const std::optional<DeviceSource> found = parse_source(source);
    REQUIRE(found.has_value());
    return *found;
  };
  CHECK(parsed("hid").driver->driver == DeviceDriver::kHid);
  CHECK(parsed("hid").argument.empty());
  CHECK(parsed("hid:A:1").argument == "A:1");
  CHECK(parsed("spacemouse:7").driver->driver == DeviceDriver::kSpacemouse);
  CHECK(parsed("pid:7").driver->driver == DeviceDriver::kPid);
  CHECK(parsed("simulated").driver->driver == DeviceDriver::kSimulated);
  CHECK(parsed("scripted").driver->driver == DeviceDriver::kScripted);
  CHECK(parsed("replay:a/b:c.mcap").driver->driver == DeviceDriver::kReplay);
  CHECK(parsed("replay:a/b:c.mcap").argument == "a/b:c.mcap");
  for (const char* other :
       {"", ":", "hi", "hidx", "hid:", "simulated:", "scripted:1", "spacemouse:", "replay", "pi"}) {
    CAPTURE(other);
    CHECK_FALSE(parse_source(other).has_value());
  }
}

TEST_CASE("kinds and numbers of drivers are each another, and each has its entry") {
  std::set<std::string_view> kinds;
  std::set<DeviceDriver> numbers;
  for (const DriverEntry& entry : drivers()) {
    CAPTURE(entry.kind);
    kinds.insert(entry.kind);
    numbers.insert(entry.driver);
    CHECK(&driver_entry(entry.driver) == &entry);
    CHECK_FALSE(entry.profile.empty());
    // It is for what is plugged in, or for what is not.
    CHECK((entry.mine != nullptr) == (entry.open != nullptr));
    CHECK((entry.make != nullptr) != (entry.open != nullptr));
  }
  CHECK(kinds.size() == drivers().size());
  CHECK(numbers.size() == drivers().size());
}

TEST_CASE("only drivers of hardware with motors count as able to push a person") {
  for (const DriverEntry& entry : drivers()) {
    CAPTURE(entry.kind);
    const bool motors = entry.driver == DeviceDriver::kHid || entry.driver == DeviceDriver::kPid;
    CHECK(entry.traits.can_push_a_person == motors);
  }
}

TEST_CASE("scripted and replayed devices follow data, the simulated one feels force") {
  for (const DriverEntry& entry : drivers()) {
    CAPTURE(entry.kind);
    const bool data =
        entry.driver == DeviceDriver::kScripted || entry.driver == DeviceDriver::kReplay;
    CHECK(entry.traits.follows_data == data);
    CHECK(entry.traits.has_no_clock == (entry.driver == DeviceDriver::kPid));
  }
}

TEST_CASE("a device inside the process has the profile's numbers and what its driver promises") {
  DeviceSheet sheet;
  sheet.profile.peak_force = 22.0;
  sheet.profile.driver = DeviceDriver::kPid;
  InsideOptions options;
  options.recorded = DeviceDriver::kHid;
  for (const DriverEntry& entry : drivers()) {
    if (entry.make == nullptr) continue;
    CAPTURE(entry.kind);
    const OpenDevice made = entry.make(sheet, options);
    const bool replay = entry.driver == DeviceDriver::kReplay;
    CHECK(made.device->profile().driver == (replay ? DeviceDriver::kHid : entry.driver));
    CHECK(made.device->profile().peak_force == 22.0);
    CHECK((made.facets.poses != nullptr) == entry.takes_poses);
    CHECK((made.facets.hand != nullptr) == entry.plays_gestures);
    CHECK((made.facets.samples != nullptr) == replay);
    CHECK(made.plug == nullptr);
  }
}

TEST_CASE("only in virtual time a scripted device holds a pose over ticks without one") {
  for (const bool virtual_time : {true, false}) {
    InsideOptions options;
    options.virtual_time = virtual_time;
    options.X_DH.p = Vector3(1.0, 2.0, 3.0);
    const OpenDevice made = driver_entry(DeviceDriver::kScripted).make({}, options);
    DeviceSample sample;
    const ReadOutcome outcome = made.device->read(0, sample);
    CHECK(outcome == (virtual_time ? ReadOutcome::kFresh : ReadOutcome::kNothing));
    if (virtual_time) CHECK(sample.p_DH == Array3{1.0, 2.0, 3.0});
  }
}

TEST_CASE("a recorded device had the driver of its source; one plugged in, that of its profile") {
  DeviceProfile profile;
  profile.driver = DeviceDriver::kPid;
  CHECK(recorded_driver("simulated", profile) == DeviceDriver::kSimulated);
  CHECK(recorded_driver("scripted", profile) == DeviceDriver::kScripted);
  CHECK(recorded_driver("pid:7", profile) == DeviceDriver::kPid);
  CHECK(recorded_driver("", profile) == DeviceDriver::kPid);
}

TEST_CASE("a device of the HID profile that is a force device too is one of the HID profile") {
  HidrawNode node;
  node.descriptor = DescriptorParts{}.joined();
  // The profile's reports have the lower numbers.
  constexpr std::uint8_t kReportId = 0x85;
  for (std::size_t k = 0; k + 1 < node.descriptor.size(); ++k) {
    if (node.descriptor[k] == kReportId) node.descriptor[k + 1] += 0x40;
  }
  REQUIRE(driver_for(node) != nullptr);
  CHECK(driver_for(node)->driver == DeviceDriver::kPid);
  node.descriptor.insert(node.descriptor.begin(), hid::kPlainDescriptor.begin(),
                         hid::kPlainDescriptor.end());
  REQUIRE(pid::is_mine(node));
  REQUIRE(driver_for(node) != nullptr);
  CHECK(driver_for(node)->driver == DeviceDriver::kHid);
  node.descriptor.clear();
  CHECK(driver_for(node) == nullptr);
}

TEST_CASE("a cap with six axes is found by its descriptor, of a receiver only what is one") {
  HidrawNode node;
  const auto driver = [&] {
    const DriverEntry* const found = driver_for(node);
    return found == nullptr ? std::string_view() : found->kind;
  };
  // By Bluetooth, of a number that nobody has listed.
  node.vendor_id = 0x256F;
  node.product_id = 0xC6FF;
  CHECK(driver().empty());
  node.descriptor = {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xC0};
  CHECK(driver() == "spacemouse");
  for (const int product : {0xC641, 0xC652, 0xC658}) {
    node.product_id = static_cast<std::uint16_t>(product);
    node.descriptor = {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xC0};
    CHECK(driver() == "spacemouse");
    node.descriptor = {0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0xC0};
    CHECK(driver().empty());
  }
  // An old one that says less.
  node.vendor_id = 0x046D;
  node.product_id = 0xC621;
  CHECK(driver() == "spacemouse");
}

TEST_CASE("a device that is not there is refused with its serial and what to do") {
  const auto attach = [](const char* source) {
    static_cast<void>(attach_device(*parse_source(source), {}, {}));
  };
  CHECK_THROWS_WITH_AS(attach("hid:none such"),
                       doctest::Contains("no hid device of serial none such is plugged in"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(attach("pid:none such"),
                       doctest::Contains("no pid device of serial none such is plugged in"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(attach("spacemouse"), doctest::Contains("--device simulated"),
                       std::runtime_error);
}

}  // namespace hapticd::test
