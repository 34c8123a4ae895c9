// The measuring of a device's damping as its ticks tell it: gathers the samples of one axis, and
// sees when it was no measuring. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/tick/push_axis.h"
#include "core/tick/tick.h"
#include "device/attach/damping_fit.h"

namespace hapticd {

class DampingRun {
 public:
  /// Along `axis`, from the tick `first` on, of the tool number `tool` of its scene.
  DampingRun(std::size_t tool, PushAxis axis, std::uint64_t first)
      : tool_(tool), axis_(axis), next_(first) {}

  /// Takes each tick in turn; how the measuring ended, once it has. Ticks before the first are
  /// passed over.
  [[nodiscard]] std::optional<DampingFit> take(const Tick& tick);

 private:
  [[nodiscard]] std::optional<RingVerdict> spoilt(const Tick& tick) const;

  std::size_t tool_;
  PushAxis axis_;
  std::uint64_t next_;  ///< tick that is to come
  bool began_ = false;
  std::uint32_t scene_id_ = 0;
  std::int64_t began_ns_ = 0;
  Array3 p_DH_{};         ///< where it began, m
  double delay_s_ = 0.0;  ///< longest so far
  double period_s_ = 0.0;
  std::vector<RingSample> samples_;
};

}  // namespace hapticd
