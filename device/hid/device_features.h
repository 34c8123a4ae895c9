// What host and device exchange beside the stream: capabilities, limits of the session,
// calibration. Each call may wait for seconds: never in the loop's thread. Not RT.
#pragma once

#include <string>

#include "device/api/report_channel.h"
#include "device/hid/profile_v1.h"

namespace hapticd::hid {

/// What the device is. False with the reason in `error` when it does not answer, or not as the
/// profile says.
[[nodiscard]] bool get_capabilities(const ReportChannel& channel, Capabilities& capabilities,
                                    std::string& error);

/// Sets the limits of the session and reads back in `config` those that hold. False as above.
[[nodiscard]] bool agree(const ReportChannel& channel, Config& config, std::string& error);

/// How far its calibration is. False as above.
[[nodiscard]] bool get_calibration(const ReportChannel& channel, Calibration& calibration,
                                   std::string& error);

/// Asks for an operation of calibration. False as above.
[[nodiscard]] bool calibrate(const ReportChannel& channel, const Calibration& asked,
                             std::string& error);

}  // namespace hapticd::hid
