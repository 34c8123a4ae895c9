// Runs code that is not ours, on bytes that are not ours, in a separate process: it may crash or
// never end, and the caller only gets an error. For programs of one thread. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace hapticd {

/// What `work` returns, run in a child process that may use `cpu_seconds` (>= 1) of processor time.
/// Throws std::runtime_error with the text of an exception that leaves `work`, or saying that the
/// child crashed or took too long. About 1 ms and one copy of the result.
[[nodiscard]] std::vector<std::uint8_t> run_isolated(
    const std::function<std::vector<std::uint8_t>()>& work, unsigned cpu_seconds);

}  // namespace hapticd
