// hapticd device list: what is plugged in that hapticd can drive. Needs no running daemon. Not RT.
#pragma once

namespace hapticd {

/// `hapticd device`, its arguments beginning with "device". Prints; returns the exit code: that of
/// list_exit_code(), or kExitUsage.
[[nodiscard]] int run_device(int argc, const char* const* argv);

}  // namespace hapticd
