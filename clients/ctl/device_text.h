// Devices as hapticctl shows them: what is known of one, its readings tick by tick, why it is not
// ready. Lines of text. Pure. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/state.pb.h"

namespace hapticd::ctl {

/// A device, with every number of its profile, where it comes from and whether it is a guess.
[[nodiscard]] std::vector<std::string> info_lines(const v1::DeviceInfo& info);

/// "0.3 N until its axes and signs are checked: hapticctl device check", or empty for one that is.
[[nodiscard]] std::string unchecked_text(const v1::DeviceInfo& info);

/// That a device with motors gives no force since its limit is 0; empty for one that gives some.
[[nodiscard]] std::string no_force_text(const v1::DeviceInfo& info);

/// The device of a tool in a State; null: there is none.
[[nodiscard]] const v1::DeviceState* device_of(const v1::State& state, std::uint32_t tool_id);

/// Readings of each device, or of that of `tool` alone.
[[nodiscard]] std::vector<std::string> reading_lines(const v1::State& state,
                                                     std::optional<std::uint32_t> tool);

/// The State without other tools and devices than those of `tool`.
[[nodiscard]] v1::State only_tool(v1::State state, std::uint32_t tool);

/// Why a device cannot be checked now, with the remedy; empty: it can.
[[nodiscard]] std::string unready_text(const v1::State& state, std::uint32_t tool_id);

}  // namespace hapticd::ctl
