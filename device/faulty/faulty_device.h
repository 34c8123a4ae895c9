// A device with a fault put in front of it, to see what happens: samples are spoiled, withheld or
// delayed, commands do not arrive, or the loop that reads is held up. Quiet for a while, then a
// fault for a while, over and over; when and how long follows from a seed, so that the same seed
// and the same clock give the same faults. RT: yes, except construction and for the two kinds that
// hold the loop up on purpose.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "device/api/haptic_device.h"

namespace hapticd {

/// What goes wrong.
enum class InjectedFault : std::uint8_t {
  kLost,
  kNan,
  kInf,
  kQuaternion,
  kFlip,
  kFrozen,
  kJump,
  kDelay,
  kWrite,
  kDetach,
  kStall,
  kLate,
};

/// One kind, for people.
struct InjectedKind {
  InjectedFault fault;
  std::string_view name;
  std::string_view what;
};

inline constexpr std::array kInjectedKinds{
    InjectedKind{InjectedFault::kLost, "lost", "no samples"},
    InjectedKind{InjectedFault::kNan, "nan", "a coordinate that is NaN"},
    InjectedKind{InjectedFault::kInf, "inf", "a coordinate that is infinite"},
    InjectedKind{InjectedFault::kQuaternion, "quaternion", "a quaternion of zeros"},
    InjectedKind{InjectedFault::kFlip, "flip", "a quaternion whose sign flips: the same pose"},
    InjectedKind{InjectedFault::kFrozen, "frozen", "the same pose over and over"},
    InjectedKind{InjectedFault::kJump, "jump", "a pose half a metre away"},
    InjectedKind{InjectedFault::kDelay, "delay", "samples that come 30 reads late"},
    InjectedKind{InjectedFault::kWrite, "write", "commands that do not arrive"},
    InjectedKind{InjectedFault::kDetach, "detach", "the device is gone"},
    InjectedKind{InjectedFault::kStall, "stall", "the loop stands still for 20 ms"},
    InjectedKind{InjectedFault::kLate, "late", "each tick takes two periods and a half"},
};

/// What is to go wrong, and when.
struct Injection {
  InjectedFault fault = InjectedFault::kLost;
  std::uint64_t seed = 1;
  std::int64_t period_ns = 1'000'000;  ///< of the loop that reads
};

/// "WHAT:SEED", or "WHAT" with seed 1; none where that makes no sense.
[[nodiscard]] std::optional<Injection> parse_injection(std::string_view text);

/// Quiet time between faults, and length of a fault, ns: from the first up to the second.
inline constexpr std::int64_t kQuietFrom_ns = 1'000'000'000;
inline constexpr std::int64_t kQuietTo_ns = 2'000'000'000;
inline constexpr std::int64_t kFaultFrom_ns = 400'000'000;
inline constexpr std::int64_t kFaultTo_ns = 700'000'000;
/// Reads by which InjectedFault::kDelay delays.
inline constexpr std::size_t kInjectedDelay = 30;
/// Length of InjectedFault::kJump, m.
inline constexpr double kInjectedJump = 0.5;
/// Length of InjectedFault::kStall, ns: four times what the guardian puts up with.
inline constexpr std::int64_t kInjectedStall_ns = 20'000'000;

class FaultyDevice final : public HapticDevice {
 public:
  /// Allocates. `device`: the one that is spoiled.
  FaultyDevice(std::unique_ptr<HapticDevice> device, const Injection& injection);

  [[nodiscard]] const DeviceProfile& profile() const noexcept override {
    return device_->profile();
  }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  /// A fault is on, as of the last read. Loop's thread.
  [[nodiscard]] bool spoiling() const noexcept { return spoiling_; }

 private:
  void follow_schedule(std::int64_t now_ns) noexcept;
  [[nodiscard]] std::int64_t draw(std::int64_t from, std::int64_t to) noexcept;
  void hold_up(bool begins) const noexcept;
  [[nodiscard]] ReadOutcome spoil(ReadOutcome outcome, const DeviceSample& fresh, bool begins,
                                  DeviceSample& sample) noexcept;

  std::unique_ptr<HapticDevice> device_;
  Injection injection_;
  std::uint64_t random_;
  std::int64_t change_ns_ = 0;  ///< when quiet or fault ends
  bool begun_ = false;
  bool spoiling_ = false;
  DeviceSample last_;              ///< fresh one, as the device gave it
  std::vector<DeviceSample> way_;  ///< of samples that are delayed
  std::size_t way_next_ = 0;
  std::size_t way_count_ = 0;
  bool flipped_ = false;
};

}  // namespace hapticd
