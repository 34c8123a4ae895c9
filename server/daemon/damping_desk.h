// The request to measure the damping of a device: begun by the loop, gathered from its ticks, and
// answered when it is over. Not RT.
#pragma once

#include <cstdint>
#include <optional>

#include "device/attach/damping_run.h"
#include "device/attach/device_check.h"
#include "server/daemon/loop_desk.h"

namespace hapticd {

/// A step of a check as a client is told of it.
[[nodiscard]] v1::Result to_result(const CheckAnswer& answer);

class DampingDesk {
 public:
  /// All outlive this.
  DampingDesk(LoopDesk& loop, ServedClients& clients) : loop_(loop), clients_(clients) {}

  /// One is under way.
  [[nodiscard]] bool busy() const noexcept { return asked_.has_value(); }
  /// Measures along the axis of `what`; the answer comes when it is over. `check` is that of the
  /// tool's device, outlives this, and keeps what is found.
  [[nodiscard]] Answer begin(const RequestId& id, const MeasureCommand& what, DeviceCheck& check);

  /// The loop may have begun it, or refused.
  void take(const LoopEvent& event);
  /// A tick is over.
  void take(const Tick& tick);

 private:
  struct Asked {
    RequestId request;
    std::uint64_t number = 0;  ///< of the command
    MeasureCommand what;
    DeviceCheck* check = nullptr;
    std::optional<DampingRun> run;  ///< empty until the loop has begun
  };

  void answer(const v1::Result& result);

  LoopDesk& loop_;
  ServedClients& clients_;
  std::optional<Asked> asked_;
};

}  // namespace hapticd
