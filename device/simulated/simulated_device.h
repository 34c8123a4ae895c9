// A haptic device and the hand that holds it, computed: the plant of a device profile (mass,
// viscous damping, Coulomb friction, encoders, motor lag, delay, saturation) coupled to a human arm
// that follows a gesture. Six axes, each apart, in the device base D; mechanical stops and
// gyroscopic terms are left out. Time is injected: read() advances to `now_ns` in fixed sub-steps,
// so the same calls give the same bits everywhere. SI. RT: yes, except construction, about 2 us per
// millisecond of its time.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/wrench.h"
#include "core/safety/echo_watch.h"
#include "device/api/gesture_hand.h"
#include "device/api/haptic_device.h"
#include "device/simulated/arm_model.h"
#include "device/simulated/axis_response.h"
#include "device/simulated/command_line.h"
#include "device/simulated/gesture.h"
#include "device/simulated/tremor.h"

namespace hapticd {

/// Sub-step of the plant, ns. Normal value 50 us: forces act to the nearest of them; shorter costs
/// time.
inline constexpr std::int64_t kPlantStep_ns = 50'000;
/// The arm's target moves on straight lines between instants so far apart, ns.
inline constexpr std::int64_t kTargetStep_ns = 1'000'000;
/// Longest time one read catches up with, ns; what is beyond is left out, as if it had not passed.
inline constexpr std::int64_t kMaxCatchUp_ns = 100'000'000;

struct SimulatedOptions {
  Pose X_DH{};                    ///< where the handle begins, at rest
  ArmKind arm = ArmKind::kLight;  ///< known_arm() of it
  std::uint64_t seed = 1;         ///< of the tremor
  ArmModels arms = usual_arms();
};

/// What the encoders do not show.
struct PlantState {
  std::int64_t t_ns = 0;
  Pose X_DH;
  Twist V_DH;           ///< in D
  Wrench F_H_D;         ///< that the motors give now
  Pose X_DH_target;     ///< of the arm
  double energy = 0.0;  ///< kinetic, of handle and hand, J
};

class SimulatedDevice final : public HapticDevice, public GestureHand {
 public:
  /// Allocates. `profile`: any; its driver is kept as it is.
  SimulatedDevice(const DeviceProfile& profile, const SimulatedOptions& options);

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  HD_REALTIME void play(const GestureTrack& track, std::uint32_t repeat) noexcept override;
  HD_REALTIME void stop_gesture() noexcept override { player_.stop(); }
  [[nodiscard]] HD_REALTIME GestureProgress gesture() const noexcept override {
    return player_.progress();
  }
  HD_REALTIME void set_arm(ArmKind kind) noexcept override;
  HD_REALTIME void set_seed(std::uint64_t seed) noexcept override;
  HD_REALTIME bool recover() noexcept override;

  // Loop's thread.
  [[nodiscard]] ArmKind arm() const noexcept { return arm_; }
  /// Puts handle and target somewhere, at rest, and ends the gesture; commands on their way stay.
  HD_REALTIME void place(const Pose& X_DH) noexcept;

  [[nodiscard]] PlantState plant() const noexcept;

 private:
  using Six = std::array<double, 6>;
  using Responses = std::array<AxisResponse, 6>;
  void advance_to(std::int64_t now_ns) noexcept;
  void begin_target_step() noexcept;
  void end_target_step() noexcept;
  void sub_step() noexcept;
  [[nodiscard]] Wrench commanded() const noexcept;
  [[nodiscard]] Six motor_mean(const Wrench& F_H_D) noexcept;
  [[nodiscard]] Pose pose() const noexcept;
  [[nodiscard]] bool sound() const noexcept;
  void measure(DeviceSample& sample) noexcept;
  [[nodiscard]] std::uint16_t flags() const noexcept;

  DeviceProfile profile_;
  ArmModels arms_;
  std::array<Responses, kArmKinds> responses_{};
  CommandLine commands_;
  GesturePlayer player_;
  Tremor tremor_;
  ArmKind arm_;
  std::uint64_t seed_;
  Pose X_DH_begin_;  ///< where the handle began
  CommandInForce in_force_;
  EchoWatch echo_;  ///< the device says which command it obeys

  // Plant: position and velocity per axis; rotation gone since the target step began.
  Quaternion q_DH_{1.0, 0.0, 0.0, 0.0};
  Six moved_{};
  Vector3 p_DH_{0.0, 0.0, 0.0};
  Six v_{};
  Six y_{};         ///< from the arm's target
  Six v_target_{};  ///< of the arm's target
  Six motor_{};     ///< what the motors give, N and N m
  double motor_decay_ = 0.0;
  double motor_share_ = 0.0;  ///< of the old value in the mean over a sub-step
  Pose X_DH_target_;          ///< tremor included
  /// What the motors gave at past target steps, for the arm that reacts late.
  std::vector<Six> felt_;
  std::size_t felt_next_ = 0;
  Six reaction_{};
  /// Poses of past samples, by their counter, for the spring that a command may bring.
  std::vector<Pose> sampled_;

  std::int64_t t_ns_ = 0;
  std::int64_t into_target_ns_ = 0;
  std::int64_t report_ns_ = 0;  ///< between samples
  std::int64_t due_ns_ = 0;     ///< of the next sample
  DeviceSample last_;
  bool begun_ = false;
  bool saturated_ = false;
};

}  // namespace hapticd
