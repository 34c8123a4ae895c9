// What a device can do beside reading and writing. Plain data.
#pragma once

#include "device/api/gesture_hand.h"
#include "device/api/pose_queue.h"
#include "device/api/sample_source.h"

namespace hapticd {

/// Null: the device has none. Valid as long as the device.
struct DeviceFacets {
  PoseQueue* poses = nullptr;       ///< it follows poses given tick by tick
  GestureHand* hand = nullptr;      ///< a computed hand holds it
  SampleSource* samples = nullptr;  ///< it gives the samples of a recording
};

}  // namespace hapticd
