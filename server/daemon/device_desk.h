// The devices of the tools: those that are plugged in are attached at the start and kept so; what
// clients are told of each; their guided check and their own calibration. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "device/attach/attach.h"
#include "server/daemon/damping_desk.h"
#include "server/daemon/force_watch.h"
#include "server/daemon/loop_desk.h"
#include "server/daemon/scene_desk.h"

namespace hapticd {

class DeviceDesk {
 public:
  /// All outlive this but `loop`, which plays what is attached here.
  DeviceDesk(PlayerOptions& player, const SceneDesk& scenes, LoopDesk& loop, ServedClients& clients)
      : player_(player), scenes_(scenes), loop_(loop), clients_(clients) {}

  /// Attaches what is plugged in, for `player` to play. Throws StartError.
  void attach();
  /// The reports that ticks may wait for; empty: the first tool's device sends none on time.
  [[nodiscard]] PaceSource pace() const;

  /// The devices of all tools.
  [[nodiscard]] Answer describe() const;
  /// One step of a check or of a calibration.
  [[nodiscard]] Answer calibrate(const RequestId& id, const v1::Calibrate& calibrate);

  /// The loop may have begun a push.
  void take(const LoopEvent& event);
  /// A tick is over.
  void take(const Tick& tick);
  /// Warns in the log of a device that gives far less stiffness than the scene asks for.
  void watch_forces(const Tick& tick);
  /// Answers the requests that devices have answered.
  void work();

 private:
  /// A push that the loop was asked for, until it has begun.
  struct AskedPush {
    std::uint64_t number = 0;  ///< of the command
    DeviceCheck* check = nullptr;
    PushAxis axis = 0;
  };
  /// A step of a device's own calibration, until the device has answered.
  struct AskedCalibration {
    RequestId request;
    Calibration* calibration = nullptr;
  };

  /// That of tool number k of the newest scene.
  [[nodiscard]] v1::DeviceInfo info(std::size_t k) const;
  /// Null: that of the tool is inside the process.
  [[nodiscard]] const AttachedDevice* attached_of(std::uint32_t tool_id) const;
  [[nodiscard]] Answer begin_calibration(const RequestId& id, const AttachedDevice& attached,
                                         CalibrationStep step);
  [[nodiscard]] Answer check(const RequestId& id, const v1::Calibrate& calibrate,
                             DeviceCheck& check);
  [[nodiscard]] Answer measure(const RequestId& id, const v1::Calibrate& calibrate,
                               DeviceCheck& check);
  [[nodiscard]] Answer push(const RequestId& id, const v1::Calibrate& calibrate,
                            DeviceCheck& check);

  PlayerOptions& player_;
  const SceneDesk& scenes_;
  LoopDesk& loop_;
  ServedClients& clients_;
  std::vector<AttachedDevice> attached_;
  DampingDesk damping_{loop_, clients_};
  std::optional<AskedPush> push_;  ///< the last one
  std::vector<AskedCalibration> calibrations_;
  ForceWatch force_watch_;
  std::array<double, kMaxTools> stiffness_bounds_{};  ///< granted, N/m
  std::array<double, kMaxTools> measured_delays_{};   ///< by drivers, s; NaN or 0: not measured
};

}  // namespace hapticd
