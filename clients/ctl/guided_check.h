// The guided first check of a device: a person leads the handle along each axis, then says where
// each small push went. Wrong axes and signs are reported with the line of the profile that
// corrects them. Then the handle is let ring, by which its damping is measured. Also the device's
// own calibration, followed to its end. Not RT.
#pragma once

#include <cstdint>

#include "clients/ctl/connection.h"
#include "clients/ctl/conversation.h"

namespace hapticd::ctl {

struct CheckChoice {
  std::uint32_t tool_id = 0;
  std::uint64_t seed = 0;  ///< of the order of pushes
  bool anyway = false;     ///< also a device that needs no check
};

/// What the daemon knows of the device of a tool. Throws Failure when the tool has none.
[[nodiscard]] v1::DeviceInfo device_info(client::Client& client, const GlobalOptions& options,
                                         std::uint32_t tool_id);

/// Takes the lease, checks, gives it back; force is off at the end whatever happened. Throws
/// Failure when the check is not passed, with what to do.
void run_check(client::Client& client, const GlobalOptions& options, const CheckChoice& choice,
               const Conversation& person);

/// Begins the device's own calibration, follows it, keeps its result; `zero`: takes the present
/// pose as zero instead. Broken off, it is aborted. Throws Failure.
void run_calibration(client::Client& client, const GlobalOptions& options, std::uint32_t tool_id,
                     bool zero, const Conversation& person);

}  // namespace hapticd::ctl
