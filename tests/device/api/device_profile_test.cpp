// Truth: the contract check itself against a device that keeps it.
#include "device/api/device_profile.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/device/api/device_contract.h"

namespace hapticd::test {
namespace {

/// Stands still at the origin and does what it is asked.
class StillDevice final : public HapticDevice {
 public:
  StillDevice() { profile_.name = {'s', 't', 'i', 'l', 'l'}; }
  const DeviceProfile& profile() const noexcept override { return profile_; }
  ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override {
    sample = {.t_ns = now_ns, .counter = ++counter_};
    return ReadOutcome::kFresh;
  }
  bool write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept override {
    bool finite = true;
    for (const Array3& vector : {command.f_H_D, command.t_H_D})
      for (const double value : vector) finite = finite && std::isfinite(value);
    return finite;
  }
  void write_zero(std::int64_t /*now_ns*/) noexcept override {}

 private:
  DeviceProfile profile_;
  std::uint64_t counter_ = 0;
};

}  // namespace

TEST_CASE("a device that stands still and obeys fulfils the contract of devices") {
  StillDevice device;
  check_device_contract(device, virtual_ticks(1'000'000), 100);
}

}  // namespace hapticd::test
