// A device that was: what gives it the samples of a recording. RT: yes, O(1).
#pragma once

#include "core/math/realtime.h"
#include "device/api/haptic_device.h"

namespace hapticd {

/// One tick of a device that was recorded.
struct ReplayedSample {
  ReadOutcome outcome = ReadOutcome::kFresh;
  DeviceSample sample;     ///< where fresh; all numbers kept to the bit
  bool write_good = true;  ///< the command of this tick reached the device
};

/// The loop's thread calls it.
class SampleSource {
 public:
  /// Queues what the next tick reads; false when the queue is full.
  HD_REALTIME virtual bool put(const ReplayedSample& tick) noexcept = 0;

 protected:
  SampleSource() = default;
  SampleSource(const SampleSource&) = default;
  SampleSource& operator=(const SampleSource&) = default;
  ~SampleSource() = default;
};

}  // namespace hapticd
