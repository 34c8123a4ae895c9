// See spacemouse_target.h.
#include "tests/fuzz/spacemouse_target.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "device/spacemouse/spacemouse_device.h"
#include "tests/support/spacemouse_axes.h"

namespace hapticd::test {
namespace {

void require(bool condition) {
  if (!condition) throw std::logic_error("a SpaceMouse did what it must not");
}

/// The bytes not yet sent.
struct Sender {
  std::span<const std::uint8_t> bytes;
  bool full = false;  ///< a report waits
};

/// One report per tick.
int send(void* input, std::uint8_t* report, std::size_t room) noexcept {
  auto& sender = *static_cast<Sender*>(input);
  if (!sender.full || sender.bytes.empty()) return 0;
  sender.full = false;
  const std::size_t length =
      std::min({std::size_t{sender.bytes[0]}, sender.bytes.size() - 1, room});
  std::copy_n(sender.bytes.data() + 1, length, report);
  sender.bytes = sender.bytes.subspan(1 + length);
  return static_cast<int>(length);
}

}  // namespace

bool check_spacemouse_bytes(std::span<const std::uint8_t> bytes) {
  DeviceProfile profile;
  profile.workspace_lower = {-0.1, -0.2, 0.05};
  profile.workspace_upper = {0.1, 0.2, 0.3};
  spacemouse::SpacemouseSettings settings;
  settings.axes = test::family_axes(0.15, 30.0);
  spacemouse::SpacemouseDevice device(profile, settings);
  Sender sender{bytes};
  ReportChannel channel;
  channel.input = &sender;
  channel.read = send;
  device.attach(channel);
  std::int64_t now_ns = 0;
  std::uint64_t counter = 0;
  while (!sender.bytes.empty()) {
    now_ns += std::int64_t{1'000'000} * (1 + sender.bytes[0] % 16);
    sender.full = true;
    DeviceSample sample;
    require(device.read(now_ns, sample) == ReadOutcome::kFresh && sample.counter > counter);
    counter = sample.counter;
    double square = 0.0;
    for (const double q : sample.q_DH) square += q * q;
    require(std::abs(square - 1.0) < 1e-9);
    for (std::size_t i = 0; i < 3; ++i) {
      require(sample.p_DH[i] >= profile.workspace_lower[i]);
      require(sample.p_DH[i] <= profile.workspace_upper[i]);
      require(std::isfinite(sample.v_DH_D[i]) && std::isfinite(sample.w_DH_D[i]));
    }
  }
  return device.counters().reports > 0;
}

}  // namespace hapticd::test
