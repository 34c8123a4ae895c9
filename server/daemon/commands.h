// What hapticd does instead of playing when a word stands first on its command line. Needs no
// running daemon. Not RT.
#pragma once

namespace hapticd {

/// `hapticd device list`, its arguments beginning with "device": what is plugged in that hapticd
/// can drive. Prints; returns the exit code: that of list_exit_code(), or kExitUsage.
[[nodiscard]] int run_device(int argc, const char* const* argv);

/// `hapticd export`, its arguments beginning with "export": a recording as a table. Prints what is
/// wrong; returns the exit code, those of hapticd.
[[nodiscard]] int run_export(int argc, const char* const* argv);

}  // namespace hapticd
